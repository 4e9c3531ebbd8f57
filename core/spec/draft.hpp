#pragma once
// Files that appear whole or not at all: written as drafts beside their place, then renamed.
#include <filesystem>
#include <string_view>

namespace flexopt {

/// Writes the content to a draft beside `file`, .NAME.HOST.PROCESS.part, and renames that: a reader
/// sees the old content or the new one. 0, or the errno of what failed; the old file then stands
/// untouched, without a draft.
int write_whole(const std::filesystem::path& file, std::string_view content);

/// 0 if a file of this name could be made, else the errno that says why not. Makes an empty draft
/// of it and removes that, and drafts of it that killed processes left.
int try_writing(const std::filesystem::path& file);

/// Removes the drafts of `folder` whose processes, of this machine, are gone: all, or those of the
/// files of one name. Whatever cannot be removed stays.
void remove_left_drafts(const std::filesystem::path& folder, std::string_view name = {});

}  // namespace flexopt
