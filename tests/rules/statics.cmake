# Objects with the lifetime of the process are not destroyed (docs/conventions.md), because streams
# run and programs call the library while the process ends. They are created with `new`, or have a
# type without a destructor, which this file lists.
cmake_policy(SET CMP0057 NEW)

# Types without a destructor.
set(plain
    bool char int unsigned float double size_t uintptr_t cudaError_t pthread_key_t
    std::once_flag std::mutex
    ArrayMemory BatchKernels CUmemGenericAllocationHandle Capture::Mode Dispatcher Driver Functions Isa KernelFlavor Kernels Known ModuleRules Optix7Flavor Row Sphere
    StackBounds TraceSet Wording engine::Wording)
# Types of objects that belong to a thread and end with it. Worker threads use workerObject instead
# (base/threads/worker_object.h).
set(of_threads Owner)

# sunstone_destroyed(result line): the type, if the line defines a variable that is destroyed when the process or a
# thread ends, else empty. A pointer or a reference is not destroyed; constexpr objects have no destructor.
function(sunstone_destroyed result line)
    set(${result} "" PARENT_SCOPE)
    set(name "[A-Za-z_][A-Za-z0-9_]*")
    if(line MATCHES "^ *((static|thread_local|inline) )+")
        string(REGEX REPLACE "^ *((static|thread_local|inline) )+" "" declaration "${line}")
    elseif(line MATCHES "^(const )?[A-Za-z_]" AND NOT line MATCHES
            "^(return|using|namespace|typedef|struct|class|enum|extern|template|friend|union|goto|case|default|constexpr|asm|else|static_assert|public|private|protected|concept|requires|export|unsigned long long|[A-Z_]+$)")
        set(declaration "${line}") # in a namespace
    else()
        return()
    endif()
    string(REGEX REPLACE "^const " "" declaration "${declaration}")
    if(NOT declaration MATCHES "^((unsigned |long |signed )*[A-Za-z_][A-Za-z0-9_:]*(<[^()]*>)?) (${name})(\\[[^]]*\\])*( = .*|;.*|{.*| =)$")
        return()
    endif()
    set(type "${CMAKE_MATCH_1}")
    string(REGEX REPLACE "^sunstone::" "" type "${type}")
    if(type IN_LIST plain OR type MATCHES "^(auto|constexpr|consteval|using|namespace|struct|class|enum|else|do|try)$"
            OR type MATCHES "^(unsigned |long |signed )+|^u?int(8|16|32|64)_t$|^std::atomic<|^std::array<(float|int|uint8_t)")
        return()
    endif()
    if(line MATCHES "thread_local " AND type IN_LIST of_threads)
        return()
    endif()
    set(${result} "${type}" PARENT_SCOPE)
endfunction()

# Checks the function itself.
foreach(line "    static Handles all;" "static const Table table;" "    static const Names kKept = {" "static Table table{1};"
        "thread_local std::vector<int> stack;" "const std::string kText = \"a\";" "std::map<int, int> table;"
        "    static SharedMemory memory;" "    thread_local SharedMemory memory;" "    static const std::map<int, int> table = {" "static Known2 known[4];")
    sunstone_destroyed(type "${line}")
    if(NOT type)
        message(FATAL_ERROR "not found: ${line}")
    endif()
endforeach()
foreach(line "    static auto* all = new Handles;" "static const auto& values = *[] {" "    static Table* table = new Table;"
        "static std::atomic<bool> told{false};" "static constexpr size_t kSize = 4;" "    static void run(int a);"
        "    thread_local Owner owner;" "static const Isa chosen = [] {" "    std::string text;" "return found;")
    sunstone_destroyed(type "${line}")
    if(type)
        message(FATAL_ERROR "wrongly found: ${line}")
    endif()
endforeach()

set(failures 0)
file(GLOB_RECURSE sources ${SOURCE_DIR}/src/*.h ${SOURCE_DIR}/src/*.cpp ${SOURCE_DIR}/src/*.cu)
list(FILTER sources EXCLUDE REGEX "_test\\.cpp$|_fuzz\\.cpp$|/testing/|/testing\\.h$|test_(driver|scene|support)\\.h$")
list(LENGTH sources count)
if(count LESS 400)
    message(FATAL_ERROR "only ${count} source files found: the check looks in the wrong place")
endif()
foreach(file ${sources})
    file(STRINGS ${file} lines REGEX "^ *((static|thread_local|inline) )+|^[A-Za-z_].*(;|=|{)")
    foreach(line IN LISTS lines)
        sunstone_destroyed(type "${line}")
        if(type)
            message("${file}: ${type} is destroyed while threads may still use it: ${line}")
            math(EXPR failures "${failures} + 1")
        endif()
    endforeach()
endforeach()
if(failures)
    message(FATAL_ERROR "${failures} objects are destroyed at the end of the process or of a thread")
endif()
message("no object of ${count} files is destroyed at the end of the process")
