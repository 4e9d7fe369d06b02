#!/usr/bin/env bash
# The first entries of the leaderboard, each a folder that `b2b benchmark verify` checks, and the board itself.
#
#   examples/benchmark_entries.sh FOLDER            the problem as it is: 100 test houses, a winter, nine seeds
#   examples/benchmark_entries.sh FOLDER --small    a trial: eight test houses, a week, two seeds
#
# Finished entries are kept: run it again to resume after an interrupt. The planner, which takes minutes per simulated
# day, runs only one day in two houses. PPO is included if `python3` (or $PYTHON) has Stable-Baselines3 and the package;
# STEPS is its training budget.
set -euo pipefail

out=${1:?give a folder}
b2b=${B2B:-b2b}
python=${PYTHON:-python3}
steps=${STEPS:-200000}
few=(--test SingleFamilyHouse-0018 SingleFamilyHouse-0387 SingleFamilyHouse-0577 SingleFamilyHouse-0645
  SingleFamilyHouse-0664 SingleFamilyHouse-0838 SingleFamilyHouse-0951 SingleFamilyHouse-0986
  --train SingleFamilyHouse-0001 SingleFamilyHouse-0002 SingleFamilyHouse-0003 SingleFamilyHouse-0004
  --period 01-01..01-07 --seed 0 1)
one_day=(--test SingleFamilyHouse-0018 SingleFamilyHouse-0387 --train SingleFamilyHouse-0001
  --period 01-10..01-10 --seed 0)
changes=()
if [ "${2:-}" = --small ]; then changes=("${few[@]}"); fi

run() {
  local name=$1
  shift
  "$b2b" benchmark run dynamics-house --out "$out/$name" --entry "$name" "$@" ${changes[@]+"${changes[@]}"} | tail -n 9
}

run reactive --policy reactive --description "the tuned reactive controllers: the baseline"
run constant --policy constant --description "the middle of every bound"
run random --policy random --description "a uniform action at every step"
results=("$out/reactive" "$out/constant" "$out/random")

for name in reactive planner; do
  "$b2b" benchmark run dynamics-house --out "$out/one-day-$name" --policy "$name" "${one_day[@]}" | tail -n 9
  results+=("$out/one-day-$name")
done

here=$(cd "$(dirname "$0")" && pwd)
if "$python" -c 'import stable_baselines3, building2building' 2>/dev/null; then
  network=$out/networks/ppo.onnx
  [ -f "$network" ] || "$python" "$here/../python/examples/benchmark_ppo.py" "$network" "$steps"
  run ppo --policy "$network" --trained-steps "$steps" --description "PPO of Stable-Baselines3, 900 training houses, one seed"
  results+=("$out/ppo")
else
  echo "PPO is left out: $python has no stable_baselines3 and building2building" >&2
fi

"$b2b" benchmark report "${results[@]}" --out "$out/leaderboard.html"
