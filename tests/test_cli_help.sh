#!/usr/bin/env bash
# tyndall help, in all its forms, from the tables that options are parsed by; docs/commands.md is what it prints.
# usage: test_cli_help.sh TYNDALL (works in the current folder, which it empties)
docs=$(cd "$(dirname "$0")/../docs" && pwd)
. "$(dirname "$0")/cli.sh"

commands() {
  "$tyndall" help | sed -n '/^commands:/,/^$/s/^  \([a-z]*\) .*/\1/p'
}

test_text() {
  expect 0 help
  cp out.txt help.txt
  expect 0 --help
  cmp -s help.txt out.txt || fail "help and --help differ"
  for command in $(commands); do
    expect 0 help "$command"
    said out.txt "^usage: tyndall $command "
    unsaid out.txt 'help-as|help-to|\(null\)'
    cp out.txt help.txt
    expect 0 "$command" --help
    cmp -s help.txt out.txt || fail "help $command and $command --help differ"
  done
  usage_error "did you mean 'render'" help rendr
  usage_error "unknown command 'nonsense'; there are: render, " help nonsense
  usage_error 'one of them' help render --markdown
  usage_error 'one argument too many' help render info
  usage_error 'unknown option --help-at' render --help-at text
}

# Options at the beginnings of lines.
options() {
  sed -En 's/^ +(-., )?(--[a-z-]+).*/\2/p'
}

# In what roff makes of it every option of the text stands at a line's beginning.
test_man() {
  expect 0 help --man pages
  present pages/tyndall.1
  for command in $(commands); do
    present "pages/tyndall-$command.1"
    said pages/tyndall.1 "^\\.BR tyndall.-$command "
  done
  expect 1 help --man /proc
  said err.txt '^tyndall: cannot write /proc/'
  if ! command -v groff > /dev/null; then
    echo "manual pages are not set: there is no groff"
    return
  fi
  for page in pages/*.1; do
    what="groff $page"
    groff -man -Tascii -P-cbou -ww "$page" > set.txt 2> err.txt || fail "it fails"
    checks=$((checks + 1))
    [ ! -s err.txt ] || fail "it warns: $(head -c 500 err.txt)"
    command=$(basename "$page" .1)
    [ "$command" != tyndall ] || continue
    "$tyndall" help "${command#tyndall-}" | options | sort > wanted.txt
    options < set.txt | sort > there.txt
    comm -23 wanted.txt there.txt > missing.txt
    checks=$((checks + 1))
    [ ! -s missing.txt ] || fail "it lacks $(tr '\n' ' ' < missing.txt)"
  done
}

test_markdown() {
  expect 0 help --markdown
  checks=$((checks + 1))
  cmp out.txt "$docs/commands.md" || fail "docs/commands.md is not this: tyndall help --markdown > docs/commands.md"
  for command in $(commands); do said out.txt "^## tyndall $command\$"; done
}

test_schema_and_options() {
  expect 0 help --schema
  checks=$((checks + 1))
  cmp out.txt "$docs/scene.schema.json" || fail "docs/scene.schema.json is not this: tyndall help --schema"
  for method in path screen fld pop lpv dom; do
    expect 0 help --options $method
    said out.txt "^. key of .render.$method. . values . default . .$"
  done
  expect 0 help --options cda
  said out.txt 'key of .render.fld.'
  usage_error "unknown method 'fdl'" help --options fdl
  usage_error 'has no options' help --options auto
  expect 0 help --man pages
  said pages/tyndall.1 '^.B render.dom.last_directions$'
}

# completed WORD...: what the shell makes of the last word of a command line, one a line, sorted.
completed() {
  COMP_WORDS=(tyndall "$@")
  COMP_CWORD=$#
  COMPREPLY=()
  _tyndall
  printf '%s\n' "${COMPREPLY[@]}" | sort
}

# completes WANTED WORD...: it makes of it these and nothing else.
completes() {
  local wanted=$1 got
  shift
  got=$(completed "$@" | paste -sd ' ')
  checks=$((checks + 1))
  what="completion of '$*'"
  [ "$got" = "$wanted" ] || fail "'$got', not '$wanted'"
}

test_completion() {
  expect 0 help --completion bash
  # shellcheck disable=SC1091
  . ./out.txt
  for command in $(commands); do
    completed "$command" -- | grep -e '^--' > there.txt
    "$tyndall" help "$command" | options | sort > wanted.txt
    comm -3 wanted.txt there.txt > differs.txt
    checks=$((checks + 1))
    what="completion of $command"
    [ ! -s differs.txt ] || fail "of help and this one alone has $(tr '\n' ' ' < differs.txt)"
  done
  touch 'a scene.json'
  completes 'render' r
  completes 'a scene.json' render a
  completes '--part --png --progress' render --p
  completes 'path pop' render --method p
  completes 'path pop' render --method = p
  completes 'a scene.json' render -o a
  completes '' render --spp ''
  completes 'path' bake --method p
  completes 'render.dom.direct render.dom.directions' render -D render.dom.dir
  completes 'auto json none plain' render --progress ''
  completes 'auto json none plain' render --progress =
  completes 'dom-convergence dom-cube dom-images dom-milk dom-rays' figure dom
  completes 'bake' bench ba
  completes 'compare convert' help co
  completes '' nonsense ''
  usage_error 'zsh' help --completion zsh
  usage_error 'one of them' help render --completion bash
}

test_text
test_man
test_markdown
test_schema_and_options
test_completion
finish 155
