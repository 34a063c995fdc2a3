# Every file and folder that a comment or a page of the documentation names exists, and every link leads to a
# file and a heading. A name without a folder stands for any file of that name, `*` for any characters.
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/links.cmake)

set(top src include tests tools bench samples scripts docs cmake assets)
set(parts api base bvh cache check compiler denoise device devlib engine math ptx texture)
# Files that are not in the tree.
set(outside
    # Examples of a reader's files.
    file.cu kernel.cu my_app.cpp my_app.cu my_app_ptx.h my_rays.cpp shade.cu
    snake_case.h snake_case_test.cpp     # examples of the form of names
    cuda_pipeline.h                      # the toolkit has it
    OptiXConfig.cmake OptiXConfigVersion.cmake) # the build makes them

# The tree as one string, a line for each file, with "/" in front: "/NAME\n" finds the end of a path.
set(patterns ${top})
list(TRANSFORM patterns PREPEND ${SOURCE_DIR}/)
list(TRANSFORM patterns APPEND /*)
file(GLOB_RECURSE tree RELATIVE ${SOURCE_DIR} ${patterns})
file(GLOB root RELATIVE ${SOURCE_DIR} ${SOURCE_DIR}/*)
list(LENGTH tree count)
if(count LESS 500)
    message(FATAL_ERROR "only ${count} files found: the check looks in the wrong place")
endif()
list(JOIN tree "\n/" tree)
list(JOIN root "\n/" root)
set(tree "\n/${tree}\n/${root}\n")

file(GLOB_RECURSE pages ${SOURCE_DIR}/docs/*.md ${SOURCE_DIR}/samples/*.md ${SOURCE_DIR}/include/*.md
    ${SOURCE_DIR}/assets/*.md)
list(APPEND pages ${SOURCE_DIR}/README.md ${SOURCE_DIR}/CONTRIBUTING.md)
file(GLOB scripts ${SOURCE_DIR}/scripts/*)
list(TRANSFORM top PREPEND ${SOURCE_DIR}/ OUTPUT_VARIABLE folders)

# sunstone_names(result pattern): the distinct matches of the pattern in comments and pages.
function(sunstone_names result pattern)
    execute_process(COMMAND grep -rhoE "(^|[^:])//.*|/\\*.*|^ \\* .*" --include=*.h --include=*.hpp --include=*.inl
            --include=*.c --include=*.cpp --include=*.cu --include=*.in ${folders}
        COMMAND grep -oE "${pattern}" COMMAND sort -u OUTPUT_VARIABLE sources)
    execute_process(COMMAND grep -rhoE "(^|[ ])# .*" --include=CMakeLists.txt --include=*.cmake --include=*.map
            --include=*.tsv --include=*.txt ${folders} ${SOURCE_DIR}/CMakeLists.txt
        COMMAND grep -oE "${pattern}" COMMAND sort -u OUTPUT_VARIABLE build)
    execute_process(COMMAND grep -hoE "(^|[ ])# .*" ${scripts}
        COMMAND grep -oE "${pattern}" COMMAND sort -u OUTPUT_VARIABLE shell)
    execute_process(COMMAND grep -hoE "${pattern}" ${pages} COMMAND sort -u OUTPUT_VARIABLE docs)
    string(REPLACE "\n" ";" names "${sources}${build}${shell}${docs}")
    list(REMOVE_ITEM names "")
    list(REMOVE_DUPLICATES names)
    set(${result} "${names}" PARENT_SCOPE)
endfunction()

set(failures "")
# sunstone_missing(name): prints the lines that have the name.
function(sunstone_missing name)
    execute_process(COMMAND grep -rnF -- "${name}" ${folders} ${SOURCE_DIR}/CMakeLists.txt ${SOURCE_DIR}/README.md
        ${SOURCE_DIR}/CONTRIBUTING.md COMMAND cut -c1-160 OUTPUT_VARIABLE places)
    message("${name} does not exist:\n${places}")
    set(failures ${failures} ${name} PARENT_SCOPE)
endfunction()

sunstone_names(files "[A-Za-z0-9_.*/<>$-]*[A-Za-z0-9_*>-]\\.(h|hpp|inl|c|cpp|cu|cmake|md|tsv|txt|map|zst|supp)\\b")
foreach(name IN LISTS files)
    string(REGEX REPLACE "^(\\.*/)+" "" path "${name}")
    string(REGEX REPLACE "^_" "*_" path "${path}") # _test.cpp is an ending
    if(path IN_LIST outside OR path MATCHES "[<>$]|^[A-Z]+\\.")
        continue() # FILE.zst and <dir>/optix.h: the reader chooses the name
    endif()
    if(path MATCHES "\\*")
        string(REPLACE "." "\\." path "${path}")
        string(REPLACE "*" "[^/\n]*" path "${path}")
        if(tree MATCHES "/${path}\n")
            continue()
        endif()
    else()
        string(FIND "${tree}" "/${path}\n" place)
        if(NOT place EQUAL -1)
            continue()
        endif()
    endif()
    sunstone_missing("${name}")
endforeach()

# Folders, and files without their ending: base/config, api/traversal for tests/api/traversal_test.cpp.
list(JOIN top "|" first)
list(JOIN parts "|" second)
sunstone_names(folders_named "(^|[ `(])(\\./)?(${first}|${second})(/[A-Za-z0-9_-]+)+[*]?")
foreach(name IN LISTS folders_named)
    string(REGEX MATCH "[a-z].*" path "${name}")
    if(path MATCHES "/[A-Z]+$|[*]$")
        continue() # a folder that a reader names; a pattern, which was a file above
    endif()
    if(NOT tree MATCHES "/${path}(_test)?[./\n]")
        sunstone_missing("${path}")
    endif()
endforeach()

# docs/guide.md has all environment variables.
execute_process(COMMAND grep -ohE "^    [{]\"[A-Z_]+\"" ${SOURCE_DIR}/src/base/config.cpp COMMAND tr -d " {\""
    OUTPUT_VARIABLE variables)
string(REGEX MATCHALL "[A-Z_]+" variables "${variables}")
list(LENGTH variables variable_count)
file(READ ${SOURCE_DIR}/docs/guide.md guide)
foreach(variable IN LISTS variables)
    string(FIND "${guide}" "| `${variable}` |" place)
    if(place EQUAL -1)
        message("docs/guide.md lacks the environment variable ${variable}")
        list(APPEND failures ${variable})
    endif()
endforeach()

sunstone_check_links(links ${SOURCE_DIR} ${pages})
foreach(link IN LISTS links)
    message("${link}")
endforeach()
list(LENGTH files file_count)
list(LENGTH folders_named folder_count)
if(file_count LESS 300 OR folder_count LESS 50 OR variable_count LESS 5)
    message(FATAL_ERROR
        "only ${file_count} files, ${folder_count} folders, ${variable_count} variables found: the patterns are wrong")
endif()
if(failures OR links)
    list(LENGTH links link_count)
    message(FATAL_ERROR "${link_count} broken links; missing: ${failures}")
endif()
message("${file_count} named files and ${folder_count} named folders exist, all links resolve")
