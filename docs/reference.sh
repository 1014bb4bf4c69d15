#!/usr/bin/env bash
# Makes the API reference and fails on a warning about a public header: reference.sh DOXYGEN FOLDER-OF-DOXYFILE
# A data member without a comment is no error: its name says enough where the comment of its struct does the rest.
set -euo pipefail

mkdir -p build/docs
"$1" "$2/Doxyfile"
if grep -v -e '(variable).* is not documented' "$2/warnings.txt" >&2; then
  echo "docs: every public class and function needs a comment in its header that Doxygen understands" >&2
  exit 1
fi
echo "docs: build/docs/html/index.html"
