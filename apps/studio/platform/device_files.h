// Where Studio's files are not those of the device, as in a page: files are brought from the device, and what is
// written is taken home by the page.
#pragma once

namespace knead::studio {

// Returns whether files must be brought.
bool has_device_files();

// Lets the person choose files of the device. They come as FilesDropped.
void choose_device_files();

}  // namespace knead::studio
