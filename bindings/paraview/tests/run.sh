#!/usr/bin/env bash
# Runs the tests of the plugin in pvbatch, on one rank and on two:  run.sh Knead.so
# KNEAD names the command, KNEAD_PYTHON the folder of Python's module (default: both of build/release). Exit status 77:
# ParaView is not installed.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
command -v pvbatch >/dev/null || {
  echo "skipped: ParaView is not installed; on Debian: apt-get install paraview paraview-dev python3-paraview"
  exit 77
}
KNEAD_PLUGIN=$(realpath "$1")
export KNEAD_PLUGIN KNEAD=${KNEAD:-$here/../../../build/release/knead}
export KNEAD_PYTHON=${KNEAD_PYTHON:-$here/../../../build/release/python}
KNEAD_SCRATCH=$(mktemp -d)
export KNEAD_SCRATCH PYTHONDONTWRITEBYTECODE=1 HOME=$KNEAD_SCRATCH OMPI_MCA_btl_vader_single_copy_mechanism=none
trap 'rm -rf "$KNEAD_SCRATCH"' EXIT
/usr/bin/python3 "$here/inputs.py"
for ranks in 1 2; do
  log=$KNEAD_SCRATCH/log_$ranks
  launcher=()
  if [[ $ranks -gt 1 ]]; then
    command -v mpirun >/dev/null || {
      echo "skipped on $ranks ranks: there is no mpirun"
      continue
    }
    launcher=(mpirun -np "$ranks" --allow-run-as-root --oversubscribe)
  fi
  for script in values failures; do
    timeout 300 "${launcher[@]}" pvbatch "$here/$script.py" >"$log" 2>&1 || {
      cat "$log"
      echo "failed: $script.py on $ranks ranks"
      exit 1
    }
    grep -qx "passed" "$log" || {
      cat "$log"
      echo "did not reach its end: $script.py on $ranks ranks"
      exit 1
    }
    echo "passed: $script.py on $ranks ranks"
  done
done
