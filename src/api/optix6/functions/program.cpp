// SPDX-License-Identifier: Apache-2.0
// Entry points of programs (section 5.13).
#include "api/optix6/call.h"

#include <filesystem>
#include <fstream>
#include <iterator>

using namespace sunstone;
using namespace sunstone::optix6;

namespace {

using Texts = std::vector<std::string>;

struct Sources {
    const void* list;
    const char* parameter;
    unsigned count = 1;
};

// `read(i)` returns the text of a source.
template <class Read>
RTresult createProgram(const char* function, RTcontext handle, const Sources& sources,
                       const char* name, RTprogram* program, const Read& read) {
    return callContext(
        function, handle,
        [&](Context& context) {
            requireNonNull(program, "program");
            *program = nullptr;
            if (sources.count == 0)
                refuse(RT_ERROR_INVALID_VALUE, "n = 0: ", sources.parameter, " is an empty list");
            requireNonNull(sources.list, sources.parameter);
            requireNonNull(name, "programName");
            Texts texts;
            for (unsigned i = 0; i < sources.count; ++i)
                texts.push_back(read(i));
            auto object = std::make_shared<Program>(context.self(), context.load(texts, name));
            *program = static_cast<RTprogram>(objects().add(std::move(object)));
        },
        RT_ERROR_INVALID_CONTEXT);
}

std::string readFile(const char* name, const std::string& parameter) {
    requireNonNull(name, parameter.c_str());
    std::ifstream file(name, std::ios::binary);
    std::error_code error;
    if (!file || std::filesystem::is_directory(name, error)) // opening a folder succeeds, too
        refuse(RT_ERROR_FILE_NOT_FOUND, "file \"", name, "\" cannot be read");
    return std::string(std::istreambuf_iterator<char>(file), {});
}

// The name of an element of a list.
std::string elementOf(const char* parameter, unsigned i) {
    return message(parameter, "[", i, "]");
}

} // namespace

SUNSTONE_API RTresult rtProgramCreateFromPTXString(RTcontext context, const char* ptx,
                                                   const char* name, RTprogram* program) {
    return createProgram(__func__, context, {ptx, "ptx"}, name, program,
                         [&](unsigned) { return std::string(ptx); });
}
SUNSTONE_API RTresult rtProgramCreateFromPTXStrings(RTcontext context, unsigned n, const char** ptx,
                                                    const char* name, RTprogram* program) {
    return createProgram(__func__, context, {ptx, "ptxStrings", n}, name, program, [&](unsigned i) {
        requireNonNull(ptx[i], elementOf("ptxStrings", i).c_str());
        return std::string(ptx[i]);
    });
}
SUNSTONE_API RTresult rtProgramCreateFromPTXFile(RTcontext context, const char* file,
                                                 const char* name, RTprogram* program) {
    return createProgram(__func__, context, {file, "filename"}, name, program,
                         [&](unsigned) { return readFile(file, "filename"); });
}
SUNSTONE_API RTresult rtProgramCreateFromPTXFiles(RTcontext context, unsigned n, const char** files,
                                                  const char* name, RTprogram* program) {
    return createProgram(__func__, context, {files, "filenames", n}, name, program,
                         [&](unsigned i) { return readFile(files[i], elementOf("filenames", i)); });
}

SUNSTONE_API RTresult rtProgramDestroy(RTprogram program) {
    return destroy<Program>(__func__, program, "program");
}
SUNSTONE_API RTresult rtProgramValidate(RTprogram program) {
    return call<Program>(__func__, program, "program", [](Program&) {});
}
SUNSTONE_API RTresult rtProgramGetContext(RTprogram program, RTcontext* context) {
    return getContext<Program>(__func__, program, "program", context);
}
SUNSTONE_API RTresult rtProgramGetId(RTprogram program, int* id) {
    return call<Program>(__func__, program, "program", [&](Program& object) {
        requireNonNull(id, "programId");
        *id = object.context()->idOf(object);
    });
}

// All callees are available at every call, so the list has no effect.
SUNSTONE_API RTresult rtProgramCallsiteSetPotentialCallees(RTprogram program, const char* name,
                                                           const int* ids, int count) {
    return call<Program>(__func__, program, "program", [&](Program& object) {
        requireNonNull(name, "name");
        if (count < 0)
            refuse(RT_ERROR_INVALID_VALUE, "numIds = ", count, " is negative");
        if (count > 0)
            requireNonNull(ids, "ids");
        const auto& programs = object.context()->programs;
        for (int i = 0; i < count; ++i)
            if (ids[i] <= 0 || size_t(ids[i]) >= programs.size() ||
                programs[size_t(ids[i])].expired())
                refuse(RT_ERROR_INVALID_VALUE, "ids[", i, "] = ", ids[i],
                       " is not the id of a live program");
    });
}
