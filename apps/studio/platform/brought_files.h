// Where Studio cannot read the computer's files, as on a page: the person brings files, and the page downloads what
// Studio writes.
#pragma once

namespace knead::studio {

// Returns whether files must be brought.
bool must_bring_files();

// Lets the person choose files of the computer. They come as FilesDropped.
void choose_files_to_bring();

}  // namespace knead::studio
