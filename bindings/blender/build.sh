#!/usr/bin/env bash
# Makes the add-on's zip:  build.sh FOLDER_OF_THE_MODULE OUT.zip   (the folder that holds knead/)
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
module=$1
out=$(realpath -m "$2")
python=/usr/bin/python3
[[ -x $python ]] || python=python3

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
package=$scratch/knead_blender
mkdir -p "$package/lib" "$package/licences"
cp "$here"/knead_blender/*.py "$package"
cp -r "$module/knead" "$package/lib"
rm -rf "$package/lib/knead/__pycache__"
: >"$package/lib/__init__.py"
"$python" "$here/icons.py" "$package/icons"
cp "$here/LICENSE" "$package" # of the add-on's own files
cp "$here/../../LICENSE" "$package/licences/knead.txt"
for library in /usr/share/doc/{libtbb12,libfmt[0-9]*,libepoxy0,libdraco[0-9]*,libmeshoptimizer[0-9]*,zlib1g,libeigen3-dev,libxsimd-dev,nlohmann-json3-dev,pybind11-dev}; do
  if [[ -f $library/copyright ]]; then cp "$library/copyright" "$package/licences/$(basename "$library").txt"; fi
done
mkdir -p "$(dirname "$out")"
(cd "$scratch" && rm -f "$out" && "$python" -m zipfile -c "$out" knead_blender)
