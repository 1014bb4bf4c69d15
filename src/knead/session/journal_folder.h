// Inside of the journal: the files in its folder.
#pragma once

#include <filesystem>
#include <string>

namespace knead::session_detail {

inline constexpr const char* kSessionFile = "session.knead";

// The whole batches of the journal in this folder. Throws IoError(read), and InvalidInput where not even the header is
// whole.
std::string read_journal(const std::filesystem::path& folder);

}  // namespace knead::session_detail
