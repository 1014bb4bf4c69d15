#!/usr/bin/env bash
# The gallery that `./dev gallery` makes: the paper's figures, each from a session in examples/gallery, and a picture of
# every tool, from the sessions in examples/tools. Shapes, deformed shapes, reports, pictures and a page are written into
# out/gallery; without a renderer, everything but the pictures. Meshes that are not part of the project come from the
# folder in KNEAD_MESHES; figures whose mesh is absent are left out.
#   KNEAD            the command
#   FIELD2D_PICTURE  the program of examples/field2d_picture.cpp; may be absent
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(dirname "$here")
knead=${KNEAD:-knead}
meshes=${KNEAD_MESHES:-$root/../shared/meshes}
out=$root/out/gallery
page=$out/gallery.md

say() { printf 'gallery: %s\n' "$*" >&2; }

# --- shapes -----------------------------------------------------------------------------------------------------------

# shape NAME: makes the procedural NAME.ply, where NAME is a kind of `knead make`, perhaps followed by _ and a variant.
shape() {
  local -A vertices=([sphere]=40000 [sphere_64k]=64000 [sphere_fine]=160000 [sphere_coarse]=2562 [box]=51202
    [cylinder]=40000 [hand]=36000 [hand_coarse]=8000 [crater]=60000 [knot]=20000 [letter-y]=20000 [figure]=30000 [torus]=20000
    [torus_coarse]=6000)
  [[ -f $out/$1.ply ]] || "$knead" make "${1%%_*}" -n "${vertices[$1]}" -q -o "$out/$1.ply"
}

# Makes the thin box_sheet.ply: a session squashes a bar, and remeshing makes its triangles even.
sheet() {
  "$knead" make box -n 6000 -q -o "$out/box_coarse.ply"
  "$knead" deform "$out/box_coarse.ply" "$out/sheet_from_box.knead" -q -o "$out/box_sheet.ply"
  "$knead" remesh "$out/box_sheet.ply" --max-edge 0.2 --min-edge 0.09 -q -o "$out/box_sheet.ply"
}

# provide FILE: puts the procedural shape or foreign mesh of this name into the gallery's folder; fails if there is none.
provide() {
  local name=${1%.ply}
  [[ -f $out/$1 ]] && return
  case $name in
    box_sheet) sheet && return ;;
    hand | hand_coarse) shape "$name" && return ;;
  esac
  case ${name%%_*} in
    sphere | box | cylinder | torus | crater | knot | letter-y | figure) shape "$name" ;;
    *) take "$1" ;;
  esac
}

take() { [[ -f $meshes/$1 ]] && ln -sf "$meshes/$1" "$out/$1"; }

# --- what sessions and reports say ------------------------------------------------------------------------------------

header() { sed -n '1s/.*"'"$2"'": *"\([^"]*\)".*/\1/p' "$1"; }                     # SESSION KEY
stamp_tools() { sed -n 's/.*"tool": *"\(stamp\|print\)".*"\(mesh\|file\)": *"\([^"]*\)".*/\3/p' "$1"; } # SESSION
value() { sed -n '/^ *"'"$2"'": *\([^,]*\),\{0,1\}$/{s//\1/p;q;}' "$1"; }          # REPORT KEY, the first of that name

certified() { value <(sed -n '/"certificate"/,$p' "$1") "$2"; }                      # REPORT KEY, of its certificate

number() { # FORMAT VALUE: "-" for null
  # shellcheck disable=SC2059  # the format is the argument
  if [[ $2 == null || -z $2 ]]; then printf -- '-'; else printf "$1" "$2"; fi
}

# --- one figure -------------------------------------------------------------------------------------------------------

# deform SESSION: makes its result and report; fails if a mesh that it needs is absent. `check=` leaves out the
# certificate where it would take minutes.
check=--check
deform() {
  local name=$1 session=$out/$1.knead file
  for file in $(header "$session" mesh) $(stamp_tools "$session"); do
    provide "$file" || {
      say "$name is left out: there is no $meshes/$file"
      return 1
    }
  done
  say "$name"
  "$knead" deform "$out/$(header "$session" mesh)" "$session" -q ${check:+"$check"} \
    --report "$out/$name.json" -o "$out/$name.ply"
}

# remesh NAME OPTIONS...: the same with remeshing: NAME_remeshed.
remesh() {
  local name=$1
  shift
  say "$name, remeshed"
  "$knead" deform "$out/$(header "$out/$name.knead" mesh)" "$out/$name.knead" -q --remesh "$@" --check \
    --report "$out/${name}_remeshed.json" -o "$out/${name}_remeshed.ply"
}

# picture NAME ARGUMENTS...: draws a picture; the arguments are those of `knead render`.
picture() {
  local name=$1
  shift
  [[ $can_draw == yes ]] || return 0
  (cd "$out" && "$knead" render "$@" -q -o "images/gallery/$name.jpg")
  printf '![%s](images/gallery/%s.jpg)\n\n' "$name" "$name" >>"$page"
}

# Writes a line with the session and what its report says.
report_of() {
  local report=$out/$1.json depth
  depth=$(value "$report" penetration)
  {
    printf '[%s](../examples/gallery/%s.knead): %s vertices, %s' "$1" "$1" "$(value "$report" vertices)" \
      "$(number %.1e "$(value "$report" volume_error)")"
    if [[ $(value "$report" self_intersections_after) =~ ^[1-9] ]]; then
      printf ', %s crossings' "$(value "$report" self_intersections_after)"
    fi
    if [[ -n $depth && $depth != null ]]; then printf ', at most %s inside the tool' "$(number %.4f "$depth")"; fi
    printf '\n\n'
  } >>"$page"
}

certificate_line() { # WHAT REPORT
  printf '%s: %s vertices, %s, %s crossings, %s degrees, %s.\n' "$1" "$(value "$2" vertices)" \
    "$(number %.1e "$(certified "$2" volume_error)")" "$(certified "$2" crossings_after)" \
    "$(number %.2g "$(certified "$2" touched_angle_after)")" "$(number %.1e "$(certified "$2" distance_max)")"
}

# Writes the certificates of a session's plain and remeshed result as two lines.
certificates_of() {
  {
    certificate_line "[$1](../examples/gallery/$1.knead)" "$out/$1.json"
    certificate_line Remeshed "$out/$1_remeshed.json"
    printf '\n'
  } >>"$page"
}

# figure NAME RENDER ARGUMENTS...: a picture of moments of the session, and its report; --and NAME ARGUMENTS
# adds another picture.
figure() {
  local name=$1 mesh
  shift
  deform "$name" || return 0
  mesh=$(header "$out/$name.knead" mesh)
  printf '%s\n\n' "$(header "$out/$name.knead" note)" >>"$page"
  local arguments=() part=$name
  while [[ $# -gt 0 ]]; do
    if [[ $1 == --and ]]; then
      picture "$part" "$mesh" --session "$name.knead" "${arguments[@]}"
      arguments=()
      part=$2
      shift 2
    else
      arguments+=("$1")
      shift
    fi
  done
  picture "$part" "$mesh" --session "$name.knead" "${arguments[@]}"
  report_of "$name"
}

# remeshed NAME 'OPTIONS' RENDER ARGUMENTS...: repeats the session of a figure above with remeshing, if that figure was
# made: pictures of the shape, its plain and its remeshed result (--and as for figure), and their certificates.
remeshed() {
  local name=$1 options part=$1_remeshed arguments=()
  [[ -f $out/$name.json ]] || return 0
  read -ra options <<<"$2"
  shift 2
  remesh "$name" "${options[@]}"
  while :; do
    if [[ $# -eq 0 || $1 == --and ]]; then
      picture "$part" "$(header "$out/$name.knead" mesh)" "$name.ply" "${name}_remeshed.ply" "${arguments[@]}"
      [[ $# -gt 0 ]] || break
      part=$2_remeshed arguments=()
      shift 2
    else
      arguments+=("$1")
      shift
    fi
  done
  certificates_of "$name"
}

distances_of() { # REPORT KEY: mean, percentile and maximum in percent of the diagonal
  local key part numbers=()
  for key in mean percentile_95 max; do
    part=$(value <(sed -n '/"'"$2"'"/,$p' "$1") "$key")
    numbers+=("$(awk "BEGIN { printf \"%.2g\", 100 * $part }")")
  done
  printf '%s (95%%: %s, all: %s)' "${numbers[@]}"
}

# fit NAME RENDER ARGUMENTS...: the shape is fitted to the result of the session with the landmarks of NAME_pairs.csv:
# a picture of the shape, the target and the fitted shape, one of the distances from the target, and a line of figures.
fit() {
  local name=$1 mesh report=$out/$1_fit.json diagonal
  shift
  check='' deform "$name" || return 0
  mesh=$(header "$out/$name.knead" mesh)
  say "$name, fitted"
  "$knead" fit "$out/$mesh" "$out/$name.ply" --landmarks "$out/${name}_pairs.csv" --surface -q --json \
    -o "$out/${name}_fit.knead" >"$report"
  "$knead" deform "$out/$mesh" "$out/${name}_fit.knead" -q -o "$out/${name}_fitted.ply"
  diagonal=$(value <("$knead" info "$out/$mesh" --json) diagonal)
  printf '%s\n\n' "$(header "$out/$name.knead" note)" >>"$page"
  picture "$name" "$mesh" "$name.ply" "${name}_fitted.ply" "$@"
  picture "${name}_distances" "$mesh" "${name}_fitted.ply" --distance-to "$name.ply" \
    --distance-max "$(awk "BEGIN { print 0.005 * $diagonal }")" "$@"
  {
    printf '[%s](../examples/gallery/%s.knead): distance in %% of the diagonal %s before, %s fitted; ' "$name" "$name" \
      "$(distances_of "$report" distance_before)" "$(distances_of "$report" distance_after)"
    printf '%s strokes of up to %s unknowns, triangles stretched by up to %s, volume error %s, %s crossings.\n\n' \
      "$(value "$report" strokes)" "$(value "$report" unknowns)" "$(number %.2g "$(value "$report" greatest_stretch)")" \
      "$(number %.1e "$(value "$report" volume_error)")" "$(value "$report" crossings_after)"
  } >>"$page"
}

# compared NAME 'OPTIONS' RENDER ARGUMENTS...: a figure that shows only this comparison.
compared() {
  deform "$1" || return 0
  printf '%s\n\n' "$(header "$out/$1.knead" note)" >>"$page"
  remeshed "$@"
}

title() { printf '## %s\n\n' "$*" >>"$page"; }

# --- the figures ------------------------------------------------------------------------------------------------------

intro() {
  cat >"$page" <<END
# Gallery: the paper's figures

\`./dev gallery --docs\` writes this page. The figures are those of W. von Funck, H. Theisel, H.-P. Seidel, "Vector Field Based
Shape Deformations", SIGGRAPH 2006; pins, poses and fits follow. A name leads to its session. \`./dev gallery\` leaves the
sessions with their shapes in \`out/gallery\`, to change:

    knead deform sphere.ply fig05_implicit.knead -o out.ply
    knead render sphere.ply --session fig05_implicit.knead --until 0,0.5,1 --tools each -o steps.png

Red is where the inner region ends, green where the outer one begins; a stamp is blue. Three shapes with edges are the shape,
the plain result, and the one with \`--remesh\`. Nothing crosses unless a line counts crossings: triangles as large as the gap can
cross although the surface does not. After the vertices comes the volume error; then smallest angle and greatest distance from the exact
image, by box diagonal, of [the certificate](command.md#the-certificate).

END
}

figure_3() {
  title "Figure 3: the field in the plane"
  printf 'p as a height field, and v = (-p_y, p_x) as line integral convolution\n([field2d_picture.cpp](../examples/field2d_picture.cpp)).\n\n' >>"$page"
  [[ $can_draw == yes && -x ${FIELD2D_PICTURE:-} ]] || return 0
  "$FIELD2D_PICTURE" "$out"
  picture fig03ab fig03a.ply fig03b.ply --size 1000x320 --view 15,35 --no-ground --close-up 0,0.1,0,3.5
  mv "$out/fig03c.jpg" "$out/images/gallery/fig03c.jpg"
  printf '![fig03c](images/gallery/fig03c.jpg)\n\n' >>"$page"
}

implicit_figures() {
  title "Figure 5: an implicit tool"
  figure fig05_implicit --until 0,0.35,0.7,1 --tools each --size 1360x300 --view 10,12 --close-up 0.6,0.25,0,3.6
  title "Figure 6: a tool that pushes"
  figure fig06_push --until 0,0.5,0.99,1 --tools each --size 1360x340 --view 60,18 --close-up 0,0.45,0,3.5
  title "Figure 7: through the shape"
  figure fig07_through --until 0,0.45,1 --tools each --size 1320x290 --view 25,12 --close-up 0.1,0,0,3.1 \
    --and fig07_cut --until 0,0.45,1 --tools each --cut 0,0,1,0 --size 1320x290 --view 25,12 --close-up 0.1,0,0,3.1
  remeshed fig07_through "" --wireframe --size 1320x440 --view 25,12 --close-up 1.3,0,0,1.3
}

surface_figures() {
  title "Figure 8: painting"
  figure fig08_paint --until 0,0.5,1 --tools each --size 1200x480 --view 170,10
  figure mesh08_paint --until 0,0.5,1 --tools each --size 1320x380 --view -20,50
  title "Figure 9: moving point sets"
  figure fig09_points --until 0,1,2 --tools each --size 1200x380 --view 14,8
  figure mesh09_points --until 0,1 --size 1000x480 --view 20,2 --close-up 0,40,60,330
  title "Figure 10: collision tools and stamping"
  figure fig10_contacts --until 0,0.6,1 --tools each --size 1200x380 --view 40,25 --close-up 0,-0.3,1,2.6
  figure fig10_stamp --until 0,0.5,1 --tools each --size 1200x380 --view 35,12 --close-up 0,0,0.3,2.6
  title "Figure 11: sharp features"
  figure fig11_features --until 0,1 --size 1200x360 --view 20,40
  figure mesh11_features --until 0,1 --size 1200x480 --view 25,15
  remeshed mesh11_features "" --wireframe --size 1320x440 --view 25,15
  title "Figure 12: small features"
  figure fig12_details --until 0,1,2 --tools none --size 1320x330 --view 75,15
  figure mesh12_leg --until 0,1 --size 1000x480 --view 60,5
  title "Figure 13: a shape pressed into the ground"
  figure fig13_crater --until 0,1 --up z --size 1200x400 --view 20,40
  figure mesh13_crater --until 0,1 --up z --size 1200x480 --view 20,30
}

bend_figures() {
  title "Figure 14: twists"
  figure fig14_twist --until 0,0.25,0.5,1 --size 1360x220 --view 15,18
  figure mesh14_twist --until 0,1 --size 1000x480 --view 60,10
  title "Figure 15: bends"
  figure fig15_bend90 --until 0,0.5,1 --size 1320x340 --view 75,12
  figure fig15_bend180 --until 0,1,2 --tools each --size 1320x340 --view 75,12
  figure fig15_box --until 0,0.5,1 --size 1320x340 --view 20,15
  title "Figure 16: limbs"
  figure fig16_limbs --until 0,1,2,3 --tools each --size 1360x400 --view 25,12
  figure mesh16_bow --until 0,1 --size 1000x480 --view 50,10
}

session_figures() {
  title "Figure 17: shapes from a sphere"
  figure fig17_spider --until 0,8,35 --tools none --size 1320x380 --view 35,30
  figure fig17_monster --until 0,5,14 --tools none --size 1320x440 --view 25,10
  remeshed fig17_monster "" --wireframe --size 1320x440 --view 25,10
}

remeshing_figures() {
  title "Figure 18: remeshing"
  compared fig18_before "--max-chord 1e-3" --wireframe --flat --size 1320x330 --view 10,12 \
    --and fig18_close --wireframe --flat --size 1320x440 --view 10,12 --close-up 1.5,0.25,0,1.6
  title "Remeshing: a thin sheet"
  compared fig18_sheet "" --wireframe --flat --size 1320x440 --view 20,25 --close-up 0,0.7,0,3.4 \
    --and fig18_sheet_cut --cut 0,0,1,0 --size 1320x440 --view 10,10 --close-up 0,0.7,0,3.4
  title "Remeshing: two fingers"
  compared fig18_fingers "" --size 1320x440 --view 15,15 \
    --and fig18_fingers_close --wireframe --flat --size 1320x440 --view 15,15 --close-up 0.22,0.72,0,0.55
  title "Remeshing: a ring through itself"
  compared fig18_ring "" --size 1320x370 --view 20,35 \
    --and fig18_ring_close --wireframe --flat --size 1320x440 --view 50,40 --close-up -0.9,0,0,1.6
}

pins_figures() {
  title "Pins: a hand counts down"
  check='' figure fig_pins_count --until 0,1,4,8,12,16 --tools none --size 1600x380 --view 20,5
  title "Pins: a raised arm and a smile"
  check='' figure mesh_pins_arm --until 0,5 --tools none --size 1000x480 --view 25,8
  figure mesh_pins_face --until 0,1 --tools none --size 1000x480 --view 0,0 --close-up 0,-5,100,210
}

pose_figures() {
  title "Pose: a hand counts to five"
  figure fig_pose_count --until 4,3,2,1,0 --tools none --size 1600x420 --view 25,5
  title "Pose: a figure bows, waves and sits"
  figure fig_pose_figure --until 0,1,3,4,6 --tools none --size 1600x480 --view 35,8
}

fit_figures() {
  title "Fits: a hand in another pose"
  # shellcheck disable=SC2016  # backquotes of Markdown
  printf '`knead fit SOURCE TARGET --landmarks pairs.csv --surface` finds pins that take one surface to the other. Tips of limbs that\nmove by their own width need landmarks. Shape, target and fitted shape; then the distances before and after, dark red from\n0.5%% of the diagonal.\n\n' >>"$page"
  fit fig_fit --size 1200x480 --view 25,12
  fit mesh_fit --size 1200x400 --view 20,35
}

# --- volume errors ----------------------------------------------------------------------------------------------------

error_row() { # WHAT SESSION THE-PAPER'S-ERROR [plain: without remeshing, which would take minutes]
  local report=$out/$2.json after=$out/$2_remeshed.json
  [[ -f $report ]] || return 0
  if [[ ${4:-} == plain ]]; then after=/dev/null; elif [[ ! -f $after ]]; then remesh "$2"; fi
  printf '| %s | %s | %s | %s |\n' "$1" "$3" \
    "$(number %.6f "$(certified "$report" volume_error)")" "$(number %.1e "$(certified "$after" volume_error)")" >>"$page"
}

volume_errors() {
  title "Volume errors"
  cat >>"$page" <<'END'
The paper's table (its section 6) beside the same kinds of scene. Vertices are where the flow takes them, but the triangles
between them cut corners; the error falls with the square of the edge length. `--remesh` gives the missing volume back.

| scene | error, paper | error | error, remeshed |
| --- | ---: | ---: | ---: |
END
  error_row "sphere, Fig. 7b" fig07_through -0.001060
  error_row "box, twisted, Fig. 14d" fig14_twist 0.000781
  error_row "box, bent, Fig. 15c" fig15_box 0.000751
  error_row "bar, as fan disk, Fig. 11c" fig11_features -0.000007
  error_row "fan disk, Fig. 11c" mesh11_features -0.000007
  error_row "armadillo, Fig. 16c" mesh16_bow 0.001344
  error_row "dragon, Fig. 19h" mesh19_dragon -0.001520 plain
  error_row "spider, Fig. 17a" fig17_spider 0.001875 plain
  error_row "own monster, Fig. 17b" fig17_monster 0.000070
  printf '\n' >>"$page"
}

models() {
  cat >>"$page" <<'END'
## Models

The shapes of `mesh` sessions are not part of the project: armadillo and dragon are from the Stanford 3D Scanning Repository
(courtesy of the Stanford Computer Graphics Laboratory), reduced; Nefertiti from odedstein/meshes, public domain; the fan disk
by Hugues Hoppe, courtesy of Pratt & Whitney; camel and hand are test data of graphics projects.
END
}

# --- pictures of the guide --------------------------------------------------------------------------------------------

# tool NAME RENDER ARGUMENTS...: images/guide/NAME.jpg of examples/tools/NAME.knead.
tool() {
  local name=$1 mesh file
  shift
  cp "$here/tools/$name.knead" "$out/tool_$name.knead"
  mesh=$(header "$out/tool_$name.knead" mesh)
  for file in "$mesh" $(stamp_tools "$out/tool_$name.knead"); do provide "$file"; done
  [[ $can_draw == yes ]] || return 0
  say "tool $name"
  (cd "$out" && "$knead" render "$mesh" --session "tool_$name.knead" --until "${until:-0,1}" "$@" -q -o "images/guide/$name.jpg")
}

tools() {
  tool implicit --size 900x300 --view 10,12
  tool paint --size 900x380 --view 170,10
  tool points --size 900x330 --view 14,8
  tool stamp --size 900x330 --view 25,15
  until=0,3 tool print --tools none --cavity --size 900x440 --view 0,0
  tool slip --size 900x330 --view 55,35
  tool rotate --size 900x330 --view 25,15
  tool stretch --size 900x330 --view 25,15
  tool twist --size 900x220 --view 15,18
  tool bend --size 900x440 --view 40,10
  until=2,4 tool plate --size 900x380 --view 20,40 --up z --tools none
  tool pins --size 900x420 --view 8,6
  tool pose --size 900x420 --view 48,8 --tools none
  tool turn --size 900x340 --view 0,75
}

# --- all of it --------------------------------------------------------------------------------------------------------

publish() {
  mkdir -p "$root/docs/images/gallery" "$root/docs/images/guide"
  cp "$page" "$root/docs/gallery.md"
  cp "$out"/images/gallery/*.jpg "$root/docs/images/gallery/"
  cp "$out"/images/guide/*.jpg "$root/docs/images/guide/"
}

main() {
  local docs=no
  if [[ ${1:-} == --docs ]]; then
    docs=yes
    shift
  fi
  [[ $# -eq 0 ]] || {
    say "usage: gallery.sh [--docs]   (--docs: copy the page and the pictures to docs/gallery.md and docs/images)"
    exit 2
  }
  mkdir -p "$out/images/gallery" "$out/images/guide"
  cp "$here"/gallery/*.knead "$here"/gallery/*.csv "$out/"
  can_draw=yes
  provide letter-y.ply
  "$knead" render "$out/letter-y.ply" --size 16x16 -q -o "$out/try.png" || {
    can_draw=no
    say "no pictures (see above); everything else is made"
  }
  rm -f "$out/try.png"
  intro
  figure_3
  implicit_figures
  surface_figures
  bend_figures
  session_figures
  remeshing_figures
  pins_figures
  pose_figures
  fit_figures
  deform mesh19_dragon || true
  volume_errors
  models
  tools
  if [[ $docs == yes ]]; then publish; fi
  say "done: $page, and the shapes, sessions, reports and pictures beside it"
}

main "$@"
