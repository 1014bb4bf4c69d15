#!/usr/bin/env bash
# Makes the API reference and fails on a warning about a public header: reference.sh DOXYGEN FOLDER-OF-DOXYFILE
# Data members, operators and constructors may do without a comment: their names and the comment of their class say enough.
set -euo pipefail

mkdir -p build/docs
"$1" "$2/Doxyfile"
if grep -vE \
  -e '\(variable\).* is not documented' \
  -e 'Member operator.* is not documented' \
  -e 'Member (\w+)\(.*\) .*of (class|struct) knead::.*\b\1 is not documented' \
  "$2/warnings.txt" >&2; then
  echo "docs: every public class and function needs a comment in its header that Doxygen understands" >&2
  exit 1
fi
echo "docs: build/docs/html/index.html"
