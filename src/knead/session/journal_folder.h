// Inside of the journal: the files in its folder.
#pragma once

#include <filesystem>
#include <string>

namespace knead::session_detail {

inline constexpr const char* kSessionFile = "session.knead";
// Two lines: the length of kSessionFile in bytes when the work was saved, and the file that it was saved to.
inline constexpr const char* kSavedFile = "saved";

// The whole batches of the journal in this folder. Throws IoError(read), and InvalidInput where not even the header is
// whole.
std::string read_journal(const std::filesystem::path& folder);

}  // namespace knead::session_detail
