# Reads a header of Knead and prints it for Doxygen: its // comments become Doxygen comments, line for line.
#
# - A block of // lines directly above a declaration documents it. The block above `#pragma once` documents the file.
# - A // comment behind a member or an enumerator documents that.
# - A block above several functions without a blank line between them documents each of them.
# - Comparisons, constructors and destructors that say nothing beyond their signature are left out.

# Escapes what Doxygen would read as a command, a tag or a link; `code` in backticks stays as it is.
function escaped(text,   piece, count, i, result) {
  count = split(text, piece, "`")
  for (i = 1; i <= count; ++i) {
    if (i % 2 == 1) {
      gsub(/\\/, "\\\\\\\\", piece[i])
      gsub(/</, "\\&lt;", piece[i])
      gsub(/>/, "\\&gt;", piece[i])
      gsub(/[@#%~]/, "\\\\&", piece[i])
      gsub(/\*/, "\\&lowast;", piece[i])
      # A dot that does not end the first sentence, which is the brief description.
      gsub(/Eq\. /, "Eq.\\&nbsp;", piece[i])
      gsub(/e\.g\. /, "e.g.\\&nbsp;", piece[i])
      gsub(/\.\(/, "\\&#46;(", piece[i])
    }
    result = result (i > 1 ? "`" : "") piece[i]
  }
  return result
}

function without_slashes(text) { sub(/^[ \t]*\/\/ ?/, "", text); return text }

# Prints the lines of the block that was collected: as documentation, or as plain comments.
function print_block(documents,   i) {
  for (i = 1; i <= block_lines; ++i) print documents ? "/// " escaped(without_slashes(block[i])) : block[i]
}

function keep_for_next(   i) {
  shared = ""
  for (i = 1; i <= block_lines; ++i) shared = shared " " escaped(without_slashes(block[i]))
}

# Whether the line is an implicit member written out: `= default`, `= delete`, or a destructor.
function says_nothing(line) {
  return line ~ /operator==.*= default;/ || line ~ /\) *(noexcept *)?= (default|delete);$/ || line ~ /^ *(virtual )?~[A-Z]/
}

# Prints a line of code; a comment at its end documents what stands before.
function print_code(line,   code, comment) {
  if (says_nothing(line)) { print ""; return }
  if (match(line, /  \/\/ /) && line !~ /^#/) {
    code = substr(line, 1, RSTART - 1)
    sub(/ *$/, "", code)
    if (code !~ /^ *}?$/ && code !~ /{$/) line = code "  ///< " escaped(substr(line, RSTART + 5))
  }
  print line
}

function starts_function(line) {
  return line ~ /^ *[A-Za-z_:\[][A-Za-z0-9_:<>,&* \[\]]* [*&]?[a-z_A-Z0-9=+*\/\[\]()-]+\(/ && line !~ /^ *(return|if|for|while|else|using|friend class)/
}

/^[ \t]*\/\// {
  if ($0 ~ /\/\/ (---|clang-format|NOLINT)/) { print ""; next }
  block[++block_lines] = $0
  next
}

/^#pragma once/ && !seen_pragma {
  seen_pragma = 1
  print "/// \\file"
  print_block(1)
  block_lines = 0
  next
}

{
  if (block_lines > 0) {
    documents = $0 !~ /^[ \t]*$/
    print_block(documents)
    if (documents && starts_function($0)) { keep_for_next(); repeat = 1 } else repeat = 0
    block_lines = 0
  } else if (repeat && ended && starts_function($0) && !says_nothing($0)) {
    printf "/** %s */ ", shared
  } else if ($0 ~ /^[ \t]*$/ || (ended && !starts_function($0))) {
    repeat = 0
  }
  print_code($0)
  ended = $0 ~ /(;|})([ ]*\/\/.*)?$/
}

END { print_block(0) }
