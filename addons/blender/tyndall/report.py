"""The list of what an export could not say, or says only nearly: a text block in Blender, and a file beside the scene."""

TEXT_NAME = "Tyndall report"


class Report:
    """Lines of two kinds, each once, in the order in which they were found."""

    def __init__(self):
        self.left_out, self.approximated = [], []

    def lose(self, owner, what):
        """Notes that a part of `owner`, such as 'material "Glass"', is not in the scene file."""
        self._add(self.left_out, owner, what)

    def approximate(self, owner, what):
        """Notes that a part of `owner` is in the scene file, but not exactly."""
        self._add(self.approximated, owner, what)

    @staticmethod
    def _add(lines, owner, what):
        line = f"{owner}: {what}"
        if line not in lines:
            lines.append(line)

    def __len__(self):
        return len(self.left_out) + len(self.approximated)

    def lines(self):
        """One line for each note, in the form of tyndall convert."""
        return [f"left out: {line}" for line in self.left_out] + [f"approximated: {line}" for line in self.approximated]

    def text(self):
        """The report as text, with one line where there is nothing to tell."""
        if not len(self):
            return "Everything in this scene is in the exported file.\n"
        return "left out or approximated:\n" + "".join(f"- {line}\n" for line in self.lines())

    def summary(self):
        """One line for the status bar."""
        return f"{len(self.left_out)} left out, {len(self.approximated)} approximated (text \"{TEXT_NAME}\")"


def owner(kind, block):
    """The name of a part of the file in the report: 'material "Glass"'."""
    return f'{kind} "{block.name}"'


def show_in_text_block(data, report):
    """Writes the report into a text block of the file, which it makes if there is none."""
    block = data.texts.get(TEXT_NAME) or data.texts.new(TEXT_NAME)
    block.clear()
    block.write(report.text())
