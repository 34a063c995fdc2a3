#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Proves that the generated checks can fail: for each change to the table below, the generator or
# the compiler must fail. Usage: mutations.sh GENERATE TABLE WORK_FOLDER COMPILE... (a command that
# compiles host_checks.cpp with WORK_FOLDER on its include path)
set -eu
generate=$1
table=$2
work=$3
shift 3
mkdir -p "$work"

"$generate" "$table" "$work"
"$@" || { echo "the unchanged table does not compile"; exit 1; }

tab=$(printf '\t')
failed=0
while read -r change; do
    change=$(printf '%s' "$change" | sed "s/~/$tab/g")
    sed "$change" "$table" >"$work/table.tsv"
    if cmp -s "$table" "$work/table.tsv"; then
        echo "changes nothing: $change"
        failed=1
    elif "$generate" "$work/table.tsv" "$work" 2>/dev/null && "$@" 2>/dev/null; then
        echo "not noticed: $change"
        failed=1
    fi
done <<'END'
s/OPTIX_ERROR_INVALID_PTX~7200/OPTIX_ERROR_INVALID_PTX~7201/
s/~OPTIX_EXCEPTION_CODE_INVALID_RAY~-9/~OPTIX_EXCEPTION_CODE_INVALID_RAY~9/
s/struct~OptixBuildInput~1032/struct~OptixBuildInput~1040/
s/OptixInstance::flags~60/OptixInstance::flags~56/
s/OptixImage2D::width~8~unsigned int/OptixImage2D::width~8~int/
s/OPTIX_ABI_VERSION~55/OPTIX_ABI_VERSION~60/
s/table slot~optixLaunch~34/table slot~optixLaunch~35/
s/host function~optixModuleDestroy~~OptixResult(OptixModule)/host function~optixModuleDestroy~~OptixResult(OptixPipeline)/
s/typedef~OptixVisibilityMask~4/typedef~OptixVisibilityMask~8/
/enumerator~OPTIX_SUCCESS/d
s/optixGetErrorName/optixGetErrorNames/
END
exit $failed
