#!/usr/bin/env bash
# Writes manual pages and shell completion from what `knead --help` and `knead COMMAND --help` print:
#   from_help.sh KNEAD FOLDER
# writes FOLDER/man/man1/knead.1.gz and knead-COMMAND.1.gz, FOLDER/bash-completion/completions/knead
# and FOLDER/zsh/vendor-completions/_knead. The folder man and its pages are made anew.
# shellcheck disable=SC2016 # what is printed is for other shells to expand
set -euo pipefail

knead=$1
folder=$2
version=$("$knead" --version)
version=${version##* }

# Reads a help text. Prints one line for each of its parts, fields separated by tabs: `about TEXT`, `usage TEXT`,
# `Section NAMES DESCRIPTION` for each entry of a section such as Options, `example TEXT` and `note TEXT`.
help_parts() {
  "$knead" "$@" --help | awk '
    function flush() { if (names != "") printf "%s\t%s\t%s\n", section, names, description; names = description = "" }
    NR == 1 { print "about\t" $0; next }
    /^Usage: / { print "usage\t" substr($0, 8); next }
    /^[A-Z][a-z]+:$/ { flush(); section = substr($0, 1, length($0) - 1); next }
    /^$/ { flush(); next }
    /^  / && section == "Examples" { print "example\t" substr($0, 3); next }
    /^  [^ ]/ {
      flush()
      names = substr($0, 3)
      if (match(names, /   *[^ ]/)) { description = substr(names, RSTART + RLENGTH - 1); names = substr(names, 1, RSTART - 1) }
      next
    }
    /^   +/ { sub(/^ +/, ""); description = description (description == "" ? "" : " ") $0; next }
    { flush(); print "note\t" $0 }
    END { flush() }'
}

mapfile -t commands < <(help_parts | awk -F'\t' '$1 == "Subcommands" { print $2 }')
[[ ${#commands[@]} -gt 0 ]] || {
  echo "from_help.sh: $knead --help lists no subcommands" >&2
  exit 1
}

# --- manual pages -----------------------------------------------------------------------------------------------------

# Prints the page of `knead`, or of the command given.
manual_page() {
  help_parts "$@" | awk -F'\t' -v version="$version" -v command="${1-}" -v commands="${commands[*]}" '
    function text(s) { gsub(/\\/, "\\e", s); gsub(/-/, "\\-", s); sub(/^[.'"'"']/, "\\\\\\&&", s); return s }
    function part(title) { if (title != last) print ".SH " title; last = title }
    BEGIN {
      name = command == "" ? "knead" : "knead-" command
      printf ".TH \"%s\" 1 \"\" \"Knead %s\" \"Knead\"\n", toupper(name), version
    }
    $1 == "about" { part("NAME"); about = $2; sub(/\.$/, "", about); print text(name) " \\- " text(about); next }
    $1 == "usage" { part("SYNOPSIS"); print ".B " text($2); next }
    $1 == "example" { if (last != "EXAMPLES") { part("EXAMPLES"); print ".EX" } print text($2); next }
    last == "EXAMPLES" && !ended { print ".EE"; ended = 1 }
    $1 == "note" { part("NOTES"); print text($2); next }
    { part($1 == "Subcommands" ? "COMMANDS" : $1 == "Positionals" ? "ARGUMENTS" : toupper($1))
      print ".TP\n.B " text($2) "\n" text($3) }
    END {
      if (last == "EXAMPLES" && !ended) print ".EE"
      if (command == "") {
        print ".SH EXIT STATUS\n0 done; 1 internal error; 2 wrong usage; 3 invalid input; 4 a requirement is not met;"
        print "5 output cannot be written; 130 interrupted."
      }
      print ".SH SEE ALSO"
      count = split(commands, others, " ")
      line = command == "" ? "" : ".BR knead (1)"
      for (i = 1; i <= count; ++i) {
        if (others[i] == command) continue
        line = line (line == "" ? "" : ",\n") ".BR knead\\-" text(others[i]) " (1)"
      }
      print line
    }'
}

# --- completion -------------------------------------------------------------------------------------------------------

# Prints one line for each option of a command, fields separated by tabs: names separated by spaces, the value's name or
# nothing, its choices separated by spaces or nothing, description. Arguments have the name `*`.
options_of() {
  help_parts "$@" | awk -F'\t' '
    $1 != "Options" && $1 != "Positionals" { next }
    {
      names = $1 == "Options" ? $2 : "*"
      sub(/ .*/, "", names)
      gsub(/,/, " ", names)
      value = $2
      if ($1 == "Options" && !sub(/^[^ ]+ /, "", value)) value = ""
      sub(/ .*/, "", value)
      choices = ""
      if (match(value, /\{.*\}/)) choices = substr(value, RSTART + 1, RLENGTH - 2)
      else if ($3 ~ /^[a-z][a-z0-9-]*(, [a-z][a-z0-9-]*)+$/) choices = $3
      gsub(/, */, " ", choices)
      sub(/[=:{].*/, "", value)
      printf "%s|%s|%s|%s\n", names, value, choices, $3
    }'
}

bash_completion() {
  cat <<'TEXT'
# bash completion for knead; made from its --help
_knead() {
  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} options='' words=''
  COMPREPLY=()
TEXT
  printf '  if [[ $COMP_CWORD -eq 1 ]]; then\n'
  printf '    mapfile -t COMPREPLY < <(compgen -W "%s" -- "$current")\n    return\n  fi\n' \
    "${commands[*]} $(options_of | cut -d'|' -f1 | tr '\n' ' ')"
  printf '  case ${COMP_WORDS[1]} in\n'
  local command names choices rest
  for command in "${commands[@]}"; do
    printf '    %s)\n      options="%s"\n' "$command" "$(options_of "$command" | cut -d'|' -f1 | grep -v '^\*' | tr '\n' ' ')"
    printf '      case $previous in\n'
    options_of "$command" | while IFS='|' read -r names _ choices rest; do
      if [[ -z $choices ]]; then continue; fi
      if [[ $names == '*' ]]; then names="$command"; fi
      printf '        %s) words="%s" ;;\n' "${names// / | }" "$choices"
    done
    printf '      esac\n      ;;\n'
  done
  cat <<'TEXT'
  esac
  if [[ $current == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$options" -- "$current")
  elif [[ -n $words ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
  else
    mapfile -t COMPREPLY < <(compgen -f -- "$current")
    compopt -o filenames 2>/dev/null
  fi
}
complete -F _knead knead
TEXT
}

# Sets `quoted` to a text quoted for a specification of zsh's _arguments within single quotes.
quote_for_zsh() {
  quoted=${1//\\/\\\\}
  quoted=${quoted//\'/\'\\\'\'}
  local sign
  for sign in '[' ']' ':'; do quoted=${quoted//"$sign"/\\"$sign"}; done
}

zsh_specification() {
  local names value choices description action name exclusive quoted
  while IFS='|' read -r names value choices description; do
    action=_files
    if [[ -n $choices ]]; then action="($choices)"; elif [[ $value != FILE* && $names != '*' ]]; then action=' '; fi
    if [[ $names == '*' ]]; then
      if [[ -z $choices ]]; then continue; fi
      printf " \\\\\n        '1:%s:%s'" "$value" "$action"
      continue
    fi
    if [[ $names == *' '* ]]; then exclusive="($names)"; else exclusive=''; fi
    quote_for_zsh "$description"
    for name in $names; do
      printf " \\\\\n        '%s%s[%s]%s'" "$exclusive" "$name" "$quoted" "${value:+:$value:$action}"
    done
  done
}

zsh_completion() {
  printf '#compdef knead\n# zsh completion for knead; made from its --help\n_knead() {\n  local -a commands=(\n'
  help_parts | while IFS=$'\t' read -r section names description; do
    if [[ $section != Subcommands ]]; then continue; fi
    quote_for_zsh "$description"
    printf "    '%s:%s'\n" "$names" "$quoted"
  done
  printf '  )\n  if (( CURRENT == 2 )); then\n    _describe -t commands command commands\n    _arguments%s\n    return\n  fi\n' \
    "$(options_of | zsh_specification)"
  printf '  local command=$words[2]\n  shift words\n  (( CURRENT-- ))\n  case $command in\n'
  local command
  for command in "${commands[@]}"; do
    printf "    %s)\n      _arguments -S%s \\\\\n        '*:file:_files'\n      ;;\n" "$command" \
      "$(options_of "$command" | zsh_specification)"
  done
  printf '  esac\n}\nif [[ $funcstack[1] == _knead ]]; then _knead "$@"; else compdef _knead knead; fi\n'
}

rm -rf "$folder/man"
mkdir -p "$folder/man/man1" "$folder/bash-completion/completions" "$folder/zsh/vendor-completions"
manual_page | gzip -9n >"$folder/man/man1/knead.1.gz"
for command in "${commands[@]}"; do manual_page "$command" | gzip -9n >"$folder/man/man1/knead-$command.1.gz"; done
bash_completion >"$folder/bash-completion/completions/knead"
zsh_completion >"$folder/zsh/vendor-completions/_knead"
