# The public headers as Doxygen takes them, for docs/api/Doxyfile: their comments are plain, and become /** .. */ before
# a declaration and /**< .. */ behind one. Headings (/* ---- .. */) and titles of groups of fields (/* Images. */) stay
# plain. What is said of several fields in one line is said of each. Line numbers stay as they are.
function escaped(text) {
    gsub(/[\\@#%<>&*`[]/, "\\\\&", text) # what Doxygen or Markdown would take for commands
    gsub(/ _/, " \\_", text)
    return text
}
function flat(text) {
    gsub(/\n *(\* )?/, " ", text)
    return text
}
# Splits "int a, b[3];" into names[] and returns how many there are; type has what stands before them.
function fields(code,    text) {
    if (code !~ /^ +[a-z].*,.*; *$/ || code ~ /[({]/) return 1
    text = code
    sub(/; *$/, "", text)
    match(text, /^ +(const )?[a-z_0-9]+( const)? /)
    type = substr(text, 1, RLENGTH)
    return split(substr(text, RLENGTH + 1), names, /, */)
}
function several(code, count, first, rest,    i) {
    printf "%s%s;%s", type, names[1], first == "" ? "" : " /**<" first "*/"
    for (i = 2; i <= count; ++i) printf " %s%s; /**<%s*/", type, names[i], rest
    print ""
}
function documented(    count) {
    if (code ~ /^ *$/) {
        print code (started ? "/**" : "/** @file " file " @brief") text "*/" after
        before = flat(text)
        started = 1
        return
    }
    count = fields(code)
    if (count > 1) several(code, count, text, flat(text))
    else print code "/**<" text "*/" after
    before = ""
}
# Adds what a line has of a comment, and ends it.
function comment(line,    end) {
    end = index(line, "*/")
    open = end == 0
    text = text escaped(open ? line : substr(line, 1, end - 1))
    after = open ? "" : substr(line, end + 2)
    if (!open) documented()
}
BEGIN {
    file = ARGV[1]
    sub(/.*\//, "", file)
}
open {
    star = /^ *\*\/$/ ? index($0, "*") - 1 : match($0, /^ +\* ?/) ? RLENGTH : 0
    text = text "\n" substr($0, 1, star)
    comment(substr($0, star + 1))
    next
}
{
    start = index($0, "/*")
    if (start > 0 && $0 !~ /\/\* ----/ && !(previous == "" && $0 ~ /^ +\/\* [A-Za-z ]+\. \*\/$/)) {
        code = substr($0, 1, start - 1)
        text = ""
        comment(substr($0, start + 2))
        previous = $0
        next
    }
    if (before != "" && start == 0 && (count = fields($0)) > 1) several($0, count, "", before)
    else print
    before = ""
    previous = $0
}
