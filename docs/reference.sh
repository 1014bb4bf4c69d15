#!/usr/bin/env bash
# Makes the API reference and fails on a warning about a public header: reference.sh DOXYGEN FOLDER-OF-DOXYFILE
# A data member, an operator or a move may do without a comment, because its name and the comment of its class say enough.
set -euo pipefail

mkdir -p build/docs
"$1" "$2/Doxyfile"
if grep -v -e '(variable).* is not documented' -e 'Member operator.* is not documented' \
  -e 'Member [A-Za-z]*([A-Za-z]* &&) .* is not documented' "$2/warnings.txt" >&2; then
  echo "docs: every public class and function needs a comment in its header that Doxygen understands" >&2
  exit 1
fi
echo "docs: build/docs/html/index.html"
