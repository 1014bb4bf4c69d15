# shellcheck shell=bash
# The packages of the system by purpose, and what installs them. Everything that ./dev ever installs stands here.
# Read by build.sh, which has say, die and have.

# A line: a purpose, and the package's name for apt (Debian, Ubuntu), dnf (Fedora), pacman (Arch), apk (Alpine), zypper
# (openSUSE) and brew (Homebrew). a|b: the first that the system has. -: it has none, or the line before brings it.
# The names of apt are tried (docs/packaging.md says where); the others are those of these systems' lists.
package_table() {
  cat <<'TABLE'
tools        g++                        gcc-c++                gcc                g++                gcc-c++                    -
tools        cmake                      cmake                  cmake              cmake              cmake                      cmake
tools        ninja-build                ninja-build            ninja              samurai            ninja                      ninja
build        libfmt-dev                 fmt-devel              fmt                fmt-dev            fmt-devel                  fmt
build        nlohmann-json3-dev         json-devel             nlohmann-json      nlohmann-json      nlohmann_json-devel        nlohmann-json
build        libcli11-dev               cli11-devel            cli11              cli11-dev|cli11    cli11-devel                cli11
build        libtbb-dev                 tbb-devel              onetbb             onetbb-dev         tbb-devel                  tbb
build        libxsimd-dev               xsimd-devel            xsimd              xsimd-dev          xsimd-devel                xsimd
build        libeigen3-dev              eigen3-devel           eigen              eigen-dev          eigen3-devel               eigen
build        libdraco-dev               draco-devel            draco              draco-dev          draco-devel                draco
build        libmeshoptimizer-dev       meshoptimizer-devel    meshoptimizer      meshoptimizer-dev  meshoptimizer-devel        meshoptimizer
build        libfreetype-dev            freetype-devel         freetype2          freetype-dev       freetype2-devel            freetype
build        libstb-dev                 stb-devel              stb                stb                stb-devel                  -
build        zlib1g-dev                 zlib-devel             zlib               zlib-dev           zlib-devel                 zlib
test         libgtest-dev               gtest-devel            gtest              gtest-dev          gtest                      googletest
test         libboost-dev               boost-devel            boost              boost-dev          libboost_headers-devel|boost-devel boost
test         libcgal-dev                CGAL-devel             cgal               cgal-dev           cgal-devel                 cgal
render       libepoxy-dev               libepoxy-devel         libepoxy           libepoxy-dev       libepoxy-devel             -
render       libegl-dev                 mesa-libEGL-devel      libglvnd           mesa-dev           Mesa-libEGL-devel          -
render       libegl1                    mesa-libEGL            mesa               mesa-egl           Mesa-libEGL1               -
render       libgl1-mesa-dri            mesa-dri-drivers       mesa               mesa-dri-gallium   Mesa-dri                   -
render       libstb-dev                 stb-devel              stb                stb                stb-devel                  -
render       pkg-config                 pkgconf-pkg-config     pkgconf            pkgconf            pkg-config                 pkgconf
studio       libglfw3-dev               glfw-devel             glfw               glfw-dev           libglfw-devel              glfw
studio       libimgui-dev               imgui-devel            imgui              imgui-dev          imgui-devel                imgui
studio       libx11-dev                 libX11-devel           libx11             libx11-dev         libX11-devel               -
studio       libxi-dev                  libXi-devel            libxi              libxi-dev          libXi-devel                -
studio       fonts-dejavu-core          dejavu-sans-fonts      ttf-dejavu         font-dejavu        dejavu-fonts               -
python       python3-dev                python3-devel          python             python3-dev        python3-devel              python
python       python3-numpy              python3-numpy          python-numpy       py3-numpy-dev      python3-numpy-devel        numpy
python       pybind11-dev               pybind11-devel         pybind11           py3-pybind11-dev   python3-pybind11-devel     pybind11
python_test  python3-pytest             python3-pytest         python-pytest      py3-pytest         python3-pytest             -
python_test  python3-hypothesis         python3-hypothesis     python-hypothesis  py3-hypothesis     python3-hypothesis         -
python_test  mypy                       python3-mypy           mypy               py3-mypy           mypy|python3-mypy          mypy
python_test  python3-meshio             -                      -                  -                  -                          -
python_test  python3-yaml               python3-pyyaml         python-yaml        py3-yaml           python3-PyYAML             -
python_test  python3-nbconvert          python3-nbconvert      jupyter-nbconvert  jupyter-nbconvert  python3-nbconvert          jupyterlab
python_test  python3-ipykernel          python3-ipykernel      python-ipykernel   py3-ipykernel      python3-ipykernel          -
python_test  python3-matplotlib         python3-matplotlib     python-matplotlib  py3-matplotlib     python3-matplotlib         python-matplotlib
wheel        python3-venv               python3                python             python3            python3                    python
studio_test  xvfb                       xorg-x11-server-Xvfb   xorg-server-xvfb   xvfb               xorg-x11-server-Xvfb       -
studio_test  xdotool                    xdotool                xdotool            xdotool            xdotool                    -
studio_test  imagemagick                ImageMagick            imagemagick        imagemagick        ImageMagick                imagemagick
studio_test  apitrace                   apitrace               apitrace           -                  apitrace                   -
studio_test  xserver-xorg-core          xorg-x11-server-Xorg   xorg-server        xorg-server        xorg-x11-server            -
studio_test  xserver-xorg-video-dummy   xorg-x11-drv-dummy     xf86-video-dummy   xf86-video-dummy   xf86-video-dummy           -
cross        python3-venv               -                      -                  -                  -                          -
cross        libgtest-dev               -                      -                  -                  -                          -
cross        qemu-user-static|qemu-user -                      -                  -                  -                          -
cross        libc6-arm64-cross          -                      -                  -                  -                          -
cross        wine                       -                      -                  -                  -                          -
cross        wine64                     -                      -                  -                  -                          -
cross        libstb-dev                 -                      -                  -                  -                          -
cross        fonts-dejavu-core          -                      -                  -                  -                          -
cross        dpkg-dev                   -                      -                  -                  -                          -
cross        libegl-dev                 -                      -                  -                  -                          -
cross        libx11-dev                 -                      -                  -                  -                          -
cross        libxi-dev                  -                      -                  -                  -                          -
cross        libxcursor-dev             -                      -                  -                  -                          -
cross        libxrandr-dev              -                      -                  -                  -                          -
cross        libxinerama-dev            -                      -                  -                  -                          -
cross        xvfb                       -                      -                  -                  -                          -
cross        xdotool                    -                      -                  -                  -                          -
clang        clang-14|clang             clang                  clang              clang              clang                      -
clang        libclang-rt-14-dev|libclang-rt-dev compiler-rt            compiler-rt        compiler-rt        -                          -
clang        llvm-14|llvm               llvm                   llvm               llvm               llvm                       llvm
lint         clang-format-14             clang-tools-extra      clang              clang-extra-tools  clang-tools                clang-format
lint         clang-tidy-14|clang-tidy   clang-tools-extra      clang              clang-extra-tools  clang-tools                llvm
lint         shellcheck                 ShellCheck             shellcheck         shellcheck         ShellCheck                 shellcheck
coverage     gcovr                      gcovr                  gcovr              gcovr              gcovr                      gcovr
docs         doxygen                    doxygen                doxygen            doxygen            doxygen                    doxygen
docs         graphviz                   graphviz               graphviz           graphviz           graphviz                   graphviz
paraview     paraview                   paraview               paraview           -                  paraview                   -
paraview     paraview-dev               paraview-devel         -                  -                  paraview-devel             -
paraview     python3-paraview           python3-paraview       -                  -                  -                          -
blender      blender                    blender                blender            blender            blender                    -
blender      xvfb                       xorg-x11-server-Xvfb   xorg-server-xvfb   xvfb               xorg-x11-server-Xvfb       -
emscripten   emscripten                 emscripten             emscripten         emscripten         -                          emscripten
node         nodejs                     nodejs                 nodejs             nodejs             nodejs                     node
npm          npm                        npm                    npm                npm                npm                        -
web          libstb-dev                 stb-devel              stb                stb                stb-devel                  -
web          fonts-dejavu-core          dejavu-sans-fonts      ttf-dejavu         font-dejavu        dejavu-fonts               -
web          fonttools|python3-fonttools fonttools              python-fonttools   py3-fonttools      python3-fonttools          fonttools
web          dpkg-dev                   -                      -                  -                  -                          -
web_test     chromium                   chromium               chromium           chromium           chromium                   -
package      dpkg-dev                   -                      -                  -                  -                          -
package      file                       -                      -                  -                  -                          -
package_test desktop-file-utils         desktop-file-utils     desktop-file-utils desktop-file-utils desktop-file-utils         desktop-file-utils
package_test libxml2-utils              libxml2                libxml2            libxml2-utils      libxml2-tools              -
package_test shared-mime-info           shared-mime-info       shared-mime-info   shared-mime-info   shared-mime-info           shared-mime-info
package_test man-db                     man-db                 man-db             man-db             man                        -
package_test zsh                        zsh                    zsh                zsh                zsh                        zsh
bench        libbenchmark-dev           google-benchmark-devel benchmark          benchmark-dev      google-benchmark-devel|benchmark-devel google-benchmark
bench        libopenmesh-dev            -                      openmesh           -                  -                          open-mesh
bench        libassimp-dev              assimp-devel           assimp             assimp-dev         assimp-devel               assimp
bench        libtinyobjloader-dev       tinyobjloader-devel    tinyobjloader      -                  tinyobjloader-devel        tinyobjloader
TABLE
  printf 'paraview_qt5 %s - - - - -\n' qtbase5-dev libqt5svg5-dev # Debian 12's ParaView
  printf 'paraview_qt6 %s - - - - -\n' qt6-base-dev qt6-svg-dev
  # What ParaView's CMake files ask for is not all among the dependencies of Debian's package.
  printf 'paraview %s - - - - -\n' libopenmpi-dev openmpi-bin libutfcpp-dev libdouble-conversion-dev \
    liblz4-dev liblzma-dev libpugixml-dev libexpat1-dev libfreetype-dev libgl2ps-dev libglew-dev libhdf5-dev libjpeg-dev \
    libpng-dev libtiff-dev libnetcdf-dev libogg-dev libtheora-dev libjsoncpp-dev libxml2-dev libproj-dev libsqlite3-dev \
    libcgns-dev libxt-dev protobuf-compiler libprotobuf-dev
}

package_managers=(apt dnf pacman apk zypper brew)

# Prints the number of this system's package manager, from 1 as its column; 0 where it is none of them.
package_column() {
  local i
  for i in "${!package_managers[@]}"; do
    if have "${package_managers[i]/#apt/apt-get}"; then
      echo $((i + 1))
      return
    fi
  done
  echo 0
}
package_column=$(package_column)
package_manager=${package_managers[package_column > 0 ? package_column - 1 : 0]}

# Prints the entries of purposes, one a line; by Debian's names where the manager is not known.
packages_of() {
  local row
  while read -ra row; do
    [[ " $* " == *" ${row[0]} "* ]] || continue
    [[ ${row[package_column > 0 ? package_column : 1]} == - ]] || printf '%s\n' "${row[package_column > 0 ? package_column : 1]}"
  done < <(package_table) | sort -u
}

is_installed() {
  case $package_manager in
    apt) grep -qx installed <<<"$(dpkg-query -W -f '${db:Status-Status}\n' "$1" 2>/dev/null)" ;;
    dnf | zypper) rpm -q --whatprovides "$1" >/dev/null 2>&1 ;;
    pacman) pacman -T "$1" >/dev/null 2>&1 ;;
    apk) apk info -e "$1" >/dev/null 2>&1 ;;
    brew) brew list --versions "$1" >/dev/null 2>&1 ;;
  esac
}

is_available() {
  case $package_manager in
    apt) [[ $(LC_ALL=C apt-cache policy "$1" 2>/dev/null) == *"Candidate: "[0-9]* ]] ;;
    dnf) [[ -n $(dnf -q repoquery --whatprovides "$1" 2>/dev/null) ]] ;;
    pacman) pacman -Si "$1" >/dev/null 2>&1 ;;
    apk) [[ -n $(apk search -e "$1" 2>/dev/null) ]] ;;
    zypper) zypper -nq search -x --provides "$1" >/dev/null 2>&1 ;;
    brew) brew info "$1" >/dev/null 2>&1 ;;
  esac
}

# Runs the package manager with the rights that it needs.
as_root() {
  if [[ $EUID -eq 0 || $package_manager == brew ]]; then
    "$@"
  elif have sudo; then
    sudo "$@"
  else
    say "no root rights; as root run: $*"
    return 1
  fi
}

refresh_packages() {
  case $package_manager in
    apt) as_root apt-get -qq -o DPkg::Lock::Timeout=900 update ;;
    dnf) as_root dnf -q makecache ;;
    pacman) : ;; # Arch wants its lists renewed together with all packages
    apk) as_root apk -q update ;;
    zypper) as_root zypper -nq refresh ;;
    brew) brew update -q ;;
  esac
}

install_packages() {
  case $package_manager in
    apt) as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=900 install -y --no-install-recommends "$@" ;;
    dnf) as_root dnf -q install -y --setopt=install_weak_deps=False "$@" ;;
    pacman) as_root pacman -S --needed --noconfirm --noprogressbar "$@" ;;
    apk) as_root apk add -q "$@" ;;
    zypper) as_root zypper -nq install --no-recommends "$@" ;;
    brew) brew install -q "$@" ;;
  esac >/dev/null
}

# Prints the entries of which no name is installed.
missing_packages() {
  local entry name names
  for entry in "$@"; do
    IFS='|' read -ra names <<<"$entry"
    for name in "${names[@]}"; do
      if is_installed "$name"; then continue 2; fi
    done
    printf '%s\n' "$entry"
  done
}

# Prints the first name of an entry that the system has.
available_package() {
  local name names
  IFS='|' read -ra names <<<"$1"
  for name in "${names[@]}"; do
    if is_available "$name"; then
      printf '%s\n' "$name"
      return
    fi
  done
  return 1
}

# Installs what is missing of the named purposes. False where not all of it is there afterwards.
require() {
  local wanted missing entry name chosen=() lacking=()
  mapfile -t wanted < <(packages_of "$@")
  if [[ $package_column -eq 0 ]]; then
    say "this system's package manager is not known; needed for $*, by Debian's names: ${wanted[*]}"
    return 0
  fi
  mapfile -t missing < <(missing_packages "${wanted[@]}")
  [[ ${#missing[@]} -gt 0 ]] || return 0
  if [[ -z $(find build/packages_refreshed -mmin -1440 2>/dev/null) ]]; then
    refresh_packages || return 1
    mkdir -p build && : >build/packages_refreshed
  fi
  for entry in "${missing[@]}"; do
    if name=$(available_package "$entry"); then chosen+=("$name"); else lacking+=("$entry"); fi
  done
  if [[ ${#chosen[@]} -gt 0 ]]; then
    say "installing ${chosen[*]}"
    install_packages "${chosen[@]}" || {
      say "still missing, see above: ${chosen[*]}"
      return 1
    }
  fi
  [[ ${#lacking[@]} -eq 0 ]] || {
    say "this system has no package for ${lacking[*]}"
    return 1
  }
}

# Ends where the compiler or CMake is too old.
check_tools() {
  local compiler=${CXX:-c++} cmake=none least=12 version=0
  if have cmake; then cmake=$(cmake --version | sed -n '1s/.* //p'); fi
  if have "$compiler"; then
    version=$("$compiler" -dumpversion)
    compiler=$("$compiler" --version | sed -n 1p)
    if [[ $compiler == *clang* ]]; then least=14; fi
  fi
  if ! have ninja || [[ ${version%%.*} -lt $least || $(printf '%s\n' 3.25 "$cmake" | sort -V | sed -n 1p) != 3.25 ]]; then
    die "needed are g++ 12 or clang 14, and CMake 3.25 (or later), and ninja; here are $compiler, CMake $cmake." \
      "The archives that ./dev release makes on another system run here."
  fi
}

# CMake says what lacks of the libraries that Knead cannot do without.
require_build() {
  require tools || say "going on with what is there"
  check_tools
  require build || say "going on with what is there"
}
require_render() { require render || say "building without the renderer, which is optional"; }
require_python() { require python || say "building without the module of Python, which is optional"; }

# What a user builds: library, command and Studio.
require_programs() {
  require_build
  require_render
  require studio || say "building without the window of Studio, which is optional"
  require_python
}

setup() {
  require_programs
  require test
  require studio_test || say "going on without the tests of Studio's window"
  require python_test || say "going on without some tests of Python's module"
}
