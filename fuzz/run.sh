#!/usr/bin/env bash
# Runs targets one after the other, SECONDS_EACH each (default 150): fuzz/run.sh [TARGET …].
set -uo pipefail
cd "$(dirname "$0")"
targets=("$@")
[ ${#targets[@]} -gt 0 ] || mapfile -t targets < <(basename -s .rs fuzz_targets/*.rs)
# SQLite defines some names twice. Allocators may refuse a size that a damaged header asks for; readers answer that with an error.
export ASAN_OPTIONS=allocator_may_return_null=1:detect_odr_violation=0 RAYON_NUM_THREADS=1
for target in "${targets[@]}"; do
  mkdir -p "corpus/$target" artifacts
  cargo +nightly fuzz run -O "$target" -- -max_total_time="${SECONDS_EACH:-150}" -rss_limit_mb=3000 -malloc_limit_mb=20000 \
    -timeout=20 -print_final_stats=1 -verbosity=1 >"artifacts/$target.log" 2>&1
  printf '%-16s exit %s, %s\n' "$target" "$?" "$(grep -a 'number_of_executed_units' "artifacts/$target.log")"
done
