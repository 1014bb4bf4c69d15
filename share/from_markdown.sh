#!/usr/bin/env bash
# Writes a manual page from a page of docs:
#   from_markdown.sh PAGE.md NAME SECTION ABOUT VERSION FOLDER
# writes FOLDER/man/manSECTION/NAME.SECTION.gz. Takes headings, paragraphs, lists, tables and indented examples.
set -euo pipefail

page=$1
name=$2
section=$3
about=$4
version=$5
folder=$6/man/man$section
mkdir -p "$folder"

awk -v name="$name" -v section="$section" -v about="$about" -v version="$version" '
  function text(s) {
    gsub(/\\/, "\\e", s)
    while (match(s, /\[[^]]*\]\([^)]*\)/)) {  # a link: its words
      link = substr(s, RSTART + 1, RLENGTH - 2)
      sub(/\].*/, "", link)
      s = substr(s, 1, RSTART - 1) link substr(s, RSTART + RLENGTH)
    }
    gsub(/\*\*/, "", s); gsub(/`/, "", s); gsub(/-/, "\\-", s)
    sub(/^[.'"'"']/, "\\\\\\&&", s)
    return s
  }
  function close_example() { if (example) print ".EE"; example = 0 }
  BEGIN {
    printf ".TH \"%s\" %s \"\" \"Knead %s\" \"Knead\"\n.SH NAME\n%s \\- %s\n.SH DESCRIPTION\n", toupper(name), section, version, text(name), text(about)
  }
  /^# / { next }
  /^## / { close_example(); print ".SH " toupper(text(substr($0, 4))); next }
  /^###* / { close_example(); sub(/^#* /, ""); print ".SS " text($0); next }
  /^    / { if (!example) print ".EX"; example = 1; print text($0); next }
  { close_example() }
  /^\| *(---|key) / { next }
  /^\|/ {
    cells = split(substr($0, 2), cell, /\|/)
    for (i in cell) gsub(/^ +| +$/, "", cell[i])
    print ".TP\n.B " text(cell[1])
    for (i = 2; i < cells; ++i) print text(cell[i])
    next
  }
  /^$/ { print ".PP"; next }
  /^- / { print ".IP \\(bu 2\n" text(substr($0, 3)); next }
  { print text($0) }
  END { close_example(); print ".SH SEE ALSO\n.BR knead (1)" }
' "$page" | gzip -9n >"$folder/$name.$section.gz"
