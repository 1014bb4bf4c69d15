# shellcheck shell=bash
# Sources of Debian's packages, for systems that have none of them built. Read with `source` at the root of the source tree.

# Puts the sources that Debian's packages imgui, glfw3 and libepoxy were made of into build/sources/NAME, once. They come
# from the system's own package servers; false where these were not reached.
fetch_sources() { # PACKAGE...
  local package file folder=$PWD/build/sources apt
  for package in "$@"; do
    [[ ! -d $folder/$package ]] || continue
    rm -rf "$folder/fetched" && mkdir -p "$folder/fetched/lists/partial" "$folder/fetched/parts"
    for file in /etc/apt/sources.list /etc/apt/sources.list.d/*; do
      if [[ -f $file ]]; then
        sed 's/^deb /deb-src /; s/^Types:.*/Types: deb-src/' "$file" >"$folder/fetched/parts/$(basename "$file")"
      fi
    done
    apt=(apt-get -qq -o Dir::Etc::sourcelist=- -o "Dir::Etc::sourceparts=$folder/fetched/parts"
      -o "Dir::State::lists=$folder/fetched/lists" -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache=)
    (cd "$folder/fetched" && "${apt[@]}" update && "${apt[@]}" source --tar-only "$package") >"$folder/log" 2>&1 || return 1
    mkdir "$folder/fetched/$package"
    tar -xf "$folder/fetched"/*.orig.tar.* --strip-components=1 -C "$folder/fetched/$package"
    mv "$folder/fetched/$package" "$folder"
    rm -rf "$folder/fetched"
  done
}
