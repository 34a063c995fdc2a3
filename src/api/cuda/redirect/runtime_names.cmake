# Writes OUTPUT: the sorted names of the functions that LIBRARY12 and LIBRARY13 export, as runtimes.h
# declares them.
set(text "// Written by runtime_names.cmake.\n#include \"api/cuda/redirect/runtimes.h\"\n\nnamespace sunstone::redirect {\n\nnamespace {\n\n")
foreach(major IN ITEMS 12 13)
    execute_process(COMMAND ${CMAKE_COMMAND} -E env LC_ALL=C ${NM} -D --defined-only --format=posix ${LIBRARY${major}}
        OUTPUT_VARIABLE table COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX MATCHALL "(^|\n)(__)?cuda[A-Za-z0-9_]*" names "${table}")
    string(REPLACE "\n" "" names "${names}")
    list(SORT names COMPARE STRING CASE SENSITIVE)
    list(REMOVE_DUPLICATES names)
    list(LENGTH names count)
    if(count LESS 300)
        message(FATAL_ERROR "${LIBRARY${major}} exports only ${count} functions")
    endif()
    list(JOIN names "\",\n    \"" list)
    string(APPEND text "constexpr const char* kNames${major}[] = {\n    \"${list}\",\n};\n\n")
    string(APPEND definitions "extern const Runtime kRuntime${major}{\"$ORIGIN/libcudart.so.${major}\", kNames${major}, ${count}};\n")
endforeach()
file(WRITE ${OUTPUT} "${text}} // namespace\n\n${definitions}\n} // namespace sunstone::redirect\n")
