# Prints the cpp blocks of a Markdown page, one after the other. Other lines become empty, so that a compiler's line
# numbers are those of the page.
/^```/ { inside = $0 == "```cpp"; print ""; next }
{ print inside ? $0 : "" }
