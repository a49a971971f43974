#!/usr/bin/env python3
"""The code speaks the field's language. usage: test_vocabulary.py SOURCE_FOLDER [--counts]

(a) Retired names occur no more often in code than the table below allows: words of this project's own for things that
    have a standard name, or one word for several things. Comments and strings do not count.
(b) No comment and no page has a sentence that begins with a bare What, Whether or How: such sentences lack their noun.
    Headings and questions may.
(c) docs/method, and pages beside it with formulas: each row of "From equations to code" that names an equation, section
    or algorithm of a paper has the form `Eq. 3 (Billeter 2012)`, and names functions by NAME(). They exist, and each of
    the row's equations is named, in the same form, in the comment above one of these functions or in its body. A
    function of the library is written NAME() in all rows.
(d) docs/glossary.md: each row names a file that exists and one of the identifiers or words in it.

--counts prints today's counts for the tables of (a) and (b) instead of failing."""
import collections
import pathlib
import re
import sys

# (a) what the name was, what to say instead, and how often it may still occur. Lower the numbers as names go; a row whose
# number has reached 0 stays, so that the name does not come back.
RETIRED = [
    # regular expression of identifiers in code, the field's term, occurrences allowed
    (r"ty_turned_find|turned_find", "ty_first_collision_source", 0),
    (r"ty_turned_extinction", "ty_scaled_extinction: sigma_t - g^l sigma_s", 0),
    (r"ty_turned_coefficient", "ty_reduced_scattering: sigma_s (1 - g)", 0),
    (r"ty_turned_\w+", "the name of the quantity", 0),
    (r"ty_ordinate_set\w*", "ty_angular_quadrature", 0),
    (r"octant_orbit", "symmetry_orbit", 0),
    (r"cross_cell", "diamond_difference_step", 0),
    (r"hold_faces", "set_to_zero_fixup", 0),
    (r"twofold|twice", "two_psi, two_mu_over_h", 0),
    (r"ty_light_map\w*|TY_LIGHT_MAP\w*", "ty_rsm or ty_shadow_map: a lightmap is a baked texture", 0),
    (r"ty_last_error", "ty_take_error, of the calling thread", 0),
    (r"ty_stops?_\w+", "ty_occlusion_distance, ty_ray_clip", 0),
    (r"ty_stopped|ty_stopping_depth", "ty_collision_probability, ty_sample_collision_depth", 0),
    (r"ty_medium_glow|ty_spans_glow|glow\w*", "emission, emitted_radiance", 0),
    (r"ty_lamp_\w+|lamps?", "point_light, local_light", 0),
    (r"ty_forward_(?:fit|lacking|fitted)\w*", "fitted_phase_function", 19),
    (r"ty_share_between", "ty_lerpf", 0),
    (r"shares?", "fraction, weight", 0),
    (r"ways?", "omega, direction, wi, wo", 0),
    (r"toward", "wi, direction; vector_irradiance in bakes", 0),
    (r"least", "min", 0),
    (r"most", "max", 3),
    (r"middle", "center", 0),
    (r"TY_TURN_SIDE", "TY_TRANSPOSE_SIDE", 0),
    (r"turned", "transposed, deflected, rotated: one word each", 0),
    (r"ty_path_turn|ty_dom_turn_to_walls", "ty_path_sample_direction, ty_dom_first_moment_at_faces", 0),
    (r"ty_sincos_turn|ty_atan2_turns", "ty_sincos_2pi, ty_atan2_over_2pi", 0),
    (r"ty_cell_soften|TY_CELL_SOFT\w*", "ty_damped_diffusivity", 0),
    (r"ty_cell_hold|TY_CELL_HELD", "ty_filter_diffusivity_update", 0),
    (r"TY_BOUNDARY_CLOSED", "TY_BOUNDARY_REFLECTING", 0),
    (r"ty_layers", "ty_all_hits", 0),
    (r"ty_encounter", "ty_intersection", 0),
    (r"ty_walker\w*|walkers?", "ty_majorant_tracker, tracker", 0),
    (r"lit_part|glows|stairs|sender", "lit_segment, emissive, staircase_factor, emitter", 0),
    (r"ty_flight_null", "ty_delta_tracking", 0),
    (r"ty_bricks", "ty_majorant_dda", 0),
    (r"ty_lamp_nearness|ty_lamp_rest", "ty_mis_weight_equiangular, ty_mis_weight_delta", 0),
    (r"albedo_even", "uniform_albedo", 0),
    (r"varies", "heterogeneous", 0),
    (r"ty_decay|ty_mean_decay", "ty_attenuation, ty_mean_attenuation", 0),
    (r"ty_exp_minus", "ty_exp_neg", 0),
    (r"ty_random_white|ty_random_next", "ty_rng_uniform, ty_sobol_next", 0),
    (r"ty_watch\w*", "ty_part_progress", 0),
    (r"ty_lit_\w+", "ty_shadow_hierarchy", 29),
    (r"stand_in|alone", "profile_light, is_point", 8),
    (r"ty_dom_send_parts", "ty_evaluate_dom_clusters", 0),
    (r"ty_inside_\w+", "ty_interior_light_fraction", 0),
    (r"TY_LIGHT_PART_\w+|ty_light_parts?", "ty_light_sample", 0),
    (r"ty_dom_parts?", "ty_light_cluster", 0),
    (r"futile|PATIENCE", "stagnating, MAX_STAGNATION", 0),
    (r"skin\w*", "interface_face", 0),
    (r"judge\w*", "estimate_convergence", 0),
    (r"murk|glance", "occlusion_medium, visibility_sample", 0),
    (r"mend\w*", "nonfinite_fixed, inpaint", 0),
    (r"survival", "rr_throughput", 0),
    (r"mixture|lows", "anderson_iterate, low_order", 0),
    (r"correction", "dsa: diffusion synthetic acceleration", 0),
    (r"sight|carried|sharp", "hidden_cells, delta_source, fine_lights", 0),
    (r"nearness", "inverse_depth", 0),
    (r"beam_room|ty_stop_room", "scratch, ty_occlusion_box", 0),
    (r"ty_mesh", "ty_accel, ty_triangle_mesh", 0),
    (r"ty_pop_frame|ty_lpv_frame", "the state that it is", 0),
    (r"ty_sharpen\w*", "ty_deconvolve_means", 0),
    (r"tilts?|ty_phase_find_(?:tilt|below)", "one_minus_mu, cdf", 6),
    (r"team|watches|called", "thread_pool, spins, wake", 0),
    (r"borrow|senders", "prior_rays, virtual_emitters", 0),
    (r"faint|seldom|needle", "min_opacity, few_scatterings, g_path_only", 0),
]

# (b) sentences that may begin so.
BARE_SENTENCES = 0

source = pathlib.Path(sys.argv[1])
only_counts = "--counts" in sys.argv[2:]
failures = []


def read(path):
    return path.read_text(encoding="utf-8", errors="replace")


def files(*folders, suffixes=(".h", ".c", ".cpp")):
    return [path for folder in folders for path in sorted((source / folder).rglob("*")) if path.suffix in suffixes]


TOKENS = re.compile(r"/\*.*?\*/|//[^\n]*|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'", re.S)


def code_of(text):
    """The text without comments, strings and characters; lines stay."""
    return TOKENS.sub(lambda match: "\n" * match.group().count("\n") or " ", text)


def comments_of(text):
    """Comments as running text, those of // on neighbouring lines as one, with the line where each begins."""
    out = []
    for match in TOKENS.finditer(text):
        token, line = match.group(), text.count("\n", 0, match.start()) + 1
        if token.startswith("/*"):
            words = re.sub(r"\n[ \t]*\*", "\n", token[2:-2])
        elif token.startswith("//"):
            words = token.lstrip("/<!")
        else:
            continue
        out.append((line, " ".join(words.split())))
    return out


# ---- (a) ----

def check_retired():
    identifiers = collections.Counter(word for path in files("src", "include", "examples")
                                      for word in re.findall(r"[A-Za-z_]\w*", code_of(read(path))))
    for pattern, instead, allowed in RETIRED:
        expression = re.compile(pattern)
        found = sum(count for word, count in identifiers.items() if expression.fullmatch(word))
        if only_counts:
            print(f'    (r"{pattern}", "{instead}", {found}),')
        elif found > allowed:
            failures.append(f"code: {pattern} occurs {found} times, {allowed} allowed: say {instead}")


# ---- (b) ----

# A sentence begins at the comment's beginning or after a full stop, question mark or exclamation mark, and is no question.
BARE = re.compile(r"(?:^|[.?!] )[-*( ]*((?:What|Whether|How)\b[^.?!]*)(?=[.!]|$)")


def sentences_of_page(text):
    """The page's paragraphs, rows and entries of lists as running text, without headings and blocks of code."""
    text = re.sub(r"^```.*?^```", lambda match: "\n" * match.group().count("\n"), text, flags=re.M | re.S)
    out, begun = [], None
    for line, words in enumerate(text.split("\n") + [""], 1):
        if begun is not None and (not words.strip() or re.match(r"\s*([-*] |\d+\. |\||#| {4})", words)):
            out.append(begun)
            begun = None
        if words.strip() and not re.match(r"#| {4}|\|", words):
            begun = (line, words.strip()) if begun is None else (begun[0], begun[1] + " " + words.strip())
    return out


def check_sentences():
    code = files("src", "include", "examples", "tools", "tests", suffixes=(".h", ".c", ".cpp", ".js"))
    texts = [(path, comments_of(read(path))) for path in code]
    texts += [(path, sentences_of_page(read(path))) for path in [*source.glob("*.md"), *sorted((source / "docs").rglob("*.md"))]]
    found = [(path, line, match[:60]) for path, texts_of in texts for line, words in texts_of for match in BARE.findall(words)]
    if only_counts:
        print(f"BARE_SENTENCES = {len(found)}")
    elif len(found) > BARE_SENTENCES:
        for path, line, words in found[:10]:
            failures.append(f"{path.relative_to(source)}:{line}: a sentence without a noun: {words} ...")
        failures.append(f"comments: {len(found)} sentences begin with What, Whether or How, {BARE_SENTENCES} allowed")


# ---- (c) ----

# Pages beside those of methods that have a table of equations.
PAGES_OF_FORMULAS = ["denoise.md", "direct.md", "marching.md", "materials.md", "phase.md", "sky.md"]

TAG = re.compile(r"(Eq\.|Sec\.|Algorithm|Table|App\.) ([0-9A-Z][0-9A-Z., \-]*(?: and [0-9A-Z.]+)?) \(([A-Z]\w+) (\d{4})\)")
LOOSE = re.compile(r"\b(?:Eq\.|Sec\.|Algorithm|Table|App\.) [0-9A-Z]")


def tags_of(text):
    """{("Eq.", "3", "Billeter", "2012"), ...}; "Eq. 3-5, 7 (Billeter 2012)" is four of them."""
    tags = set()
    for kind, numbers, author, year in TAG.findall(" ".join(text.replace("*", " ").split())):
        for part in re.split(r", | and ", numbers):
            ends = part.split("-")
            if len(ends) == 2 and all(end.isdigit() for end in ends):
                tags |= {(kind, str(n), author, year) for n in range(int(ends[0]), int(ends[1]) + 1)}
            else:
                tags.add((kind, part.strip(), author, year))
    return tags


def functions():
    """name: texts of all definitions and declarations with the comment block that stands right above each."""
    out = {}
    head = re.compile(r"^(?!typedef|return|else|#|[ \t{}/*])[^\n;={}()]*?\b(\w+)\((?:[^;{}]*)\)\s*(\{|;)", re.M)
    for path in files("src", "include"):
        text = read(path)
        plain = TOKENS.sub(lambda match: re.sub(r"[^\n]", " ", match.group()), text)
        for match in head.finditer(plain):
            end = plain.find("\n}", match.end()) + 2 if match.group(2) == "{" else match.end()
            above = re.search(r"/\*(?:(?!\*/).)*\*/\s*\Z", text[:match.start()], re.S)
            comment = above.group() if above and "\n\n" not in above.group()[above.group().rindex("*/"):] else ""
            line_end = text.find("\n", end)
            out.setdefault(match.group(1), []).append(comment + text[match.start():line_end])
    return out


def tell(tag):
    return f"{tag[0]} {tag[1]} ({tag[2]} {tag[3]})"


def check_equations():
    known = functions()
    rows = 0
    pages = [*sorted((source / "docs/method").glob("*.md")), *(source / "docs" / name for name in PAGES_OF_FORMULAS)]
    for page in pages:
        section = re.search(r"^## From equations to code\n(.*?)^## ", read(page), flags=re.M | re.S)
        if section is None and page.name in PAGES_OF_FORMULAS:
            failures.append(f"docs/{page.name}: lacks the section From equations to code")
        for row in re.findall(r"^\|.*\|$", section.group(1) if section else "", flags=re.M):
            where, tags = f"{page.relative_to(source)}: {row[:70]}", tags_of(row)
            names = re.findall(r"`(\w+)\(\)`", row)
            failures.extend(f"{where}: {name} is a function: {name}()" for name in re.findall(r"`(ty_\w+)`", row) if name in known)
            if LOOSE.search(TAG.sub("", row)):
                failures.append(f"{where}: an equation without its paper, such as Eq. 3 (Billeter 2012)")
            for name in names:
                if name not in known:
                    failures.append(f"{where}: there is no function {name} in src")
            if not tags:
                continue
            rows += 1
            if not names:
                failures.append(f"{where}: names no function such as `ty_hg()`")
            said = set().union(*(tags_of(text) for name in names for text in known.get(name, [])), set())
            for tag in sorted(tags - said):
                failures.append(f"{where}: {tell(tag)} is named neither above nor in {', '.join(names) or 'any function'}")
    if rows < 20:
        failures.append(f"docs/method: only {rows} rows name an equation")


# ---- (d) ----

def check_glossary():
    lines = re.findall(r"^\|(.*)\|$", read(source / "docs/glossary.md"), flags=re.M)[2:]
    rows = [cells for cells in ([cell.strip() for cell in line.split("|")] for line in lines) if len(cells) == 4]
    if len(rows) != len(lines):
        failures.append("docs/glossary.md: each row has term, symbol, unit and where")
    if len(rows) < 60:
        failures.append(f"docs/glossary.md: only {len(rows)} terms")
    for term, _, _, where in rows:
        paths = re.findall(r"`((?:src|include|tests|docs)/[^`]+)`", where)
        words = [word for word in re.findall(r"`([^`]+)`", where) if word not in paths]
        if not paths:
            failures.append(f"docs/glossary.md: {term}: names no file")
        missing = [path for path in paths if not (source / path).is_file()]
        failures.extend(f"docs/glossary.md: {term}: there is no {path}" for path in missing)
        if words and paths and not missing:
            texts = "".join(read(source / path) for path in paths)
            failures.extend(f"docs/glossary.md: {term}: no {word} in {', '.join(paths)}" for word in words
                            if not re.search(rf"(?<!\w){re.escape(word)}(?!\w)", texts))


check_retired()
check_sentences()
if only_counts:
    sys.exit(0)
check_equations()
check_glossary()
print("\n".join(failures) or "the words are the field's")
sys.exit(1 if failures else 0)
