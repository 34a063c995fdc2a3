# sunstone_part(name FOLDERS folders... DEPS parts... LINK libraries...) declares a part of the engine.
# The .cpp files of the current folder and of FOLDERS become the object library sunstone_<name>; their
# *_test.cpp files become one test program, test_<name>, whose cases ctest lists one by one. The test
# links the part and the parts named in DEPS (all of them, also indirect ones), not the whole engine.

add_library(sunstone_options INTERFACE)
target_include_directories(sunstone_options INTERFACE ${PROJECT_SOURCE_DIR}/src)
target_compile_options(sunstone_options INTERFACE
    $<$<COMPILE_LANGUAGE:CXX>:-Wall -Wextra -Wno-missing-field-initializers -Wno-unused-command-line-argument>
    $<$<BOOL:${SUNSTONE_WERROR}>:-Werror>
    # Compilers must not fuse operations, because results must not depend on it; code that needs FMA
    # requests it.
    -ffp-contract=off)
if(SUNSTONE_SANITIZE)
    target_compile_options(sunstone_options INTERFACE
        -fsanitize=${SUNSTONE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=undefined
        # enum: C callers may pass values without an enumerator; the library returns an error for
        # them.
        -fno-sanitize=vptr,function,enum)
    target_link_options(sunstone_options INTERFACE -fsanitize=${SUNSTONE_SANITIZE})
    # C programs of the tests use the libraries without these options.
    add_link_options($<$<LINK_LANGUAGE:C>:-fsanitize=${SUNSTONE_SANITIZE}>)
endif()

set(SUNSTONE_PARTS "" CACHE INTERNAL "")

function(sunstone_part name)
    cmake_parse_arguments(PART "" "" "FOLDERS;DEPS;LINK;EXCLUDE" ${ARGN})
    set(sources "")
    foreach(folder . ${PART_FOLDERS})
        file(GLOB found CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cpp)
        if(NOT found AND NOT folder STREQUAL ".")
            message(FATAL_ERROR "part ${name}: no sources in ${folder}")
        endif()
        list(APPEND sources ${found})
    endforeach()
    list(TRANSFORM sources REPLACE "/\\./" "/")
    set(tests ${sources})
    list(FILTER tests INCLUDE REGEX "_test\\.cpp$")
    set(fuzzers ${sources})
    list(FILTER fuzzers INCLUDE REGEX "_fuzz\\.cpp$")
    list(REMOVE_ITEM sources "" ${tests} ${fuzzers} ${PART_EXCLUDE})
    if(sources)
        add_library(sunstone_${name} OBJECT ${sources})
        target_link_libraries(sunstone_${name} PUBLIC sunstone_options ${PART_LINK})
        set(SUNSTONE_PARTS ${SUNSTONE_PARTS} sunstone_${name} CACHE INTERNAL "")
    endif()
    if(tests AND SUNSTONE_BUILD_TESTS)
        list(TRANSFORM PART_DEPS PREPEND sunstone_)
        sunstone_test(${name} ${tests} LINK sunstone_${name} ${PART_DEPS} ${PART_LINK})
    endif()
endfunction()

# sunstone_test(name sources... LINK libraries... PROPERTIES p v...): a GoogleTest program, label = name.
# tests/main/main.cpp is its main().
function(sunstone_test name)
    cmake_parse_arguments(TEST "" "" "LINK;PROPERTIES" ${ARGN})
    find_package(GTest REQUIRED)
    include(GoogleTest)
    if(NOT TARGET sunstone_test_main)
        add_library(sunstone_test_main OBJECT ${PROJECT_SOURCE_DIR}/tests/main/main.cpp)
        target_link_libraries(sunstone_test_main PUBLIC sunstone_options GTest::gtest)
    endif()
    add_executable(test_${name} ${TEST_UNPARSED_ARGUMENTS})
    target_link_libraries(test_${name} PRIVATE sunstone_options ${TEST_LINK} sunstone_test_main
        GTest::gtest ${CMAKE_DL_LIBS})
    gtest_discover_tests(test_${name} TEST_PREFIX ${name}. PROPERTIES LABELS ${name}
        ${TEST_PROPERTIES} DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60)
endfunction()
