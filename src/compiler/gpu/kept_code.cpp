// SPDX-License-Identifier: Apache-2.0
// GPU code in the disk cache: its key and its format.
#include "compiler/gpu/pipeline.h"

#include "compiler/flavor.h"
#include "compiler/store/build_id.h"
#include "compiler/store/bytes.h"
#include "compiler/store/digest.h"

#include <algorithm>

namespace sunstone::compiler {

std::string keyOf(const GpuPipelineRequest& request) {
    Digest digest;
    digest.add(buildId()); // the run-time is a part of the build
    digest.add("gpu");
    digest.add(request.pipeline.flavor ? request.pipeline.flavor->name() : optix7Flavor().name());
    digest.add(uint64_t(request.target.computeCapability));
    digest.add(uint64_t(request.target.ptxVersion));
    digest.add(uint64_t(request.target.driverVersion));
    digest.add(uint64_t(request.maxTraceDepth));
    digest.add(uint64_t(request.mostInlined));
    digest.add(uint64_t(request.part));
    addRules(digest, request.pipeline.rules);
    digest.add(uint64_t(request.pipeline.programs.size()));
    digest.add(uint64_t(request.groups.size()));
    std::vector<const Source*> modules; // equal texts may be several modules
    for (const ProgramRequest& program : request.pipeline.programs) {
        auto found = std::find(modules.begin(), modules.end(), program.module.get());
        digest.add(uint64_t(found - modules.begin()));
        if (found == modules.end())
            modules.push_back(program.module.get());
        digest.add(program.module->digest());
        digest.add(program.function);
        digest.add(uint64_t(program.kind));
        digest.add(uint64_t(program.optLevel));
        digest.add(uint64_t(int64_t(program.payloadType)));
        addRules(digest, program.moduleRules ? *program.moduleRules : ModuleRules());
    }
    for (const GpuGroup& group : request.groups) {
        for (const size_t value : {size_t(group.number), size_t(group.kind), size_t(group.builtin)})
            digest.add(uint64_t(value));
        for (const size_t program : group.programs)
            digest.add(uint64_t(program));
    }
    for (const auto& [name, value] : request.constants) {
        digest.add(name);
        digest.add(uint64_t(value));
    }
    return digest.take();
}

std::string keyOf(const GpuTarget& target, std::string_view kernel) {
    Digest digest;
    digest.add(buildId()); // its text is a part of the build
    digest.add("kernel");
    digest.add(uint64_t(target.computeCapability));
    digest.add(uint64_t(target.driverVersion));
    digest.add(kernel);
    return digest.take();
}

namespace {

constexpr uint32_t kMagic = 0x43555047; // "GPUC"

// The text is kept only if there is no machine code.
std::string serialize(const GpuCode& code) {
    const auto& [ptx, feedback, stack, calls, machineCode, laneMemory, inStep, takesTurns, recurses,
                 frameBytes, isState] = code; // names every field
    ByteWriter out;
    out.number(kMagic);
    for (const uint64_t value :
         {stack.entry, stack.waiting, stack.other, uint64_t(stack.isMeasured), laneMemory,
          uint64_t(inStep), uint64_t(takesTurns), uint64_t(recurses), frameBytes,
          uint64_t(isState)})
        out.wide(value);
    out.text(feedback);
    out.text(calls);
    out.text(machineCode.empty() ? ptx : std::string());
    out.text(machineCode);
    return out.take();
}

bool deserialize(std::string_view bytes, GpuCode& code) {
    ByteReader in(bytes);
    if (in.number() != kMagic)
        return false;
    code.stack.entry = in.wide();
    code.stack.waiting = in.wide();
    code.stack.other = in.wide();
    code.stack.isMeasured = in.wide() != 0;
    code.laneMemoryBytes = in.wide();
    code.walksInStep = in.wide() != 0;
    code.takesTurns = in.wide() != 0;
    code.recurses = in.wide() != 0;
    code.frameBytes = in.wide();
    code.hasState = in.wide() != 0;
    code.feedback = in.text();
    code.calls = in.text();
    code.ptx = in.text();
    code.machineCode = in.text();
    return in.finished() && code.ptx.empty() != code.machineCode.empty();
}

} // namespace

bool findGpuPipeline(const std::string& key, ObjectStore& store, GpuCode& code) {
    std::string bytes;
    return store.find(key, bytes) && deserialize(bytes, code);
}

void keepGpuPipeline(const std::string& key, const GpuCode& code, ObjectStore& store) {
    store.insert(key, serialize(code));
}

} // namespace sunstone::compiler
