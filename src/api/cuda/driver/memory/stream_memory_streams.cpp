// SPDX-License-Identifier: Apache-2.0
// Memory words that streams write and wait for, and stream attributes. Compiled twice, see shell.h.
#include "api/cuda/driver/device_faults.h"
#include "api/cuda/driver/shell.h"
#include "base/process_end.h"

#include <array>
#include <chrono>
#include <cstring>
#include <thread>

using namespace sunstone;
using namespace sunstone::api::cuda;

namespace {

template <class Word>
Word* wordAt(CUdeviceptr address) {
    require(address && address % sizeof(Word) == 0, "the address is null or not aligned");
    if (!cpu::memory().contains(reinterpret_cast<void*>(address), sizeof(Word)))
        refuse(CUDA_ERROR_INVALID_VALUE, "address ", reinterpret_cast<void*>(address), " + ",
               sizeof(Word), " is in no allocation");
    return reinterpret_cast<Word*>(address);
}

template <class Word>
bool holds(Word seen, Word value, unsigned flags) {
    switch (flags & 3) {
    case CU_STREAM_WAIT_VALUE_GEQ:
        return std::make_signed_t<Word>(seen - value) >= 0;
    case CU_STREAM_WAIT_VALUE_EQ:
        return seen == value;
    case CU_STREAM_WAIT_VALUE_AND:
        return (seen & value) != 0;
    default:
        return Word(~(seen | value)) != 0;
    }
}

// The word may be freed while a stream waits for it.
template <class Word>
Word load(const Word* word) {
    Word seen = 0;
    accessMemory("a wait for a word", [&] { seen = __atomic_load_n(word, __ATOMIC_ACQUIRE); });
    return seen;
}

using Step = std::function<void()>;

template <class Word>
Step waitStep(CUdeviceptr address, Word value, unsigned flags) {
    require((flags & ~unsigned(CU_STREAM_WAIT_VALUE_FLUSH)) <= CU_STREAM_WAIT_VALUE_NOR,
            "unknown flags");
    Word* const word = wordAt<Word>(address);
    watchProcessEnd();
    return [=] {
        // The word may be written by the host, another stream or a kernel.
        for (unsigned tries = 0; !holds(load(word), value, flags) && !processEnds(); ++tries)
            if (tries < 1000) {
                std::this_thread::yield();
            } else {
                cpu::memory().sealFreed(); // the word may have been freed meanwhile
                std::this_thread::sleep_for(std::chrono::microseconds(50));
            }
    };
}
template <class Word>
Step writeStep(CUdeviceptr address, Word value, unsigned flags) {
    require(flags <= CU_STREAM_WRITE_VALUE_NO_MEMORY_BARRIER, "unknown flags");
    Word* const word = wordAt<Word>(address);
    return [=] {
        accessMemory("a write of a word", [=] { __atomic_store_n(word, value, __ATOMIC_SEQ_CST); });
    };
}

Step stepOf(const CUstreamBatchMemOpParams& op) {
    const auto& wait = op.waitValue;
    const auto& write = op.writeValue;
    switch (op.operation) {
    case CU_STREAM_MEM_OP_WAIT_VALUE_32:
        return waitStep(wait.address, wait.value, wait.flags);
    case CU_STREAM_MEM_OP_WAIT_VALUE_64:
        return waitStep<uint64_t>(wait.address, wait.value64, wait.flags);
    case CU_STREAM_MEM_OP_WRITE_VALUE_32:
        return writeStep(write.address, write.value, write.flags);
    case CU_STREAM_MEM_OP_WRITE_VALUE_64:
        return writeStep<uint64_t>(write.address, write.value64, write.flags);
    case CU_STREAM_MEM_OP_BARRIER:
        require(op.memoryBarrier.flags <= CU_STREAM_MEMORY_BARRIER_TYPE_GPU, "unknown flags");
        return [] { std::atomic_thread_fence(std::memory_order_seq_cst); };
    case CU_STREAM_MEM_OP_FLUSH_REMOTE_WRITES:
        refuse(CUDA_ERROR_NOT_SUPPORTED, "there are no remote writes to flush "
                                         "(CU_DEVICE_ATTRIBUTE_CAN_FLUSH_REMOTE_WRITES is 0)");
    default:
        refuse(CUDA_ERROR_INVALID_VALUE, "unknown operation ", int(op.operation));
    }
}

CUresult queue(const char* function, CUstream stream,
               const std::function<std::vector<Step>()>& make) {
    return guarded(function, {Needs::kQueue, stream}, [&] {
        const cpu::StreamPtr target = resolveStream(stream);
        std::vector<Step> steps = make();
        if (cpu::streams().isCapturing(target)) {
            cpu::streams().captureState(target).capture->invalidated = true;
            throw cpu::CaptureError(cpu::CaptureError::kUnsupported,
                                    "words that streams write or wait for cannot be captured");
        }
        const std::weak_ptr home = cpu::contexts().shareCurrent();
        cpu::streams().submit(target, [home, steps = std::move(steps)] {
            runInContext(home, [&] {
                for (const Step& step : steps)
                    step();
            });
        });
    });
}

CUresult batch(CUstream stream, unsigned count, const CUstreamBatchMemOpParams* params,
               unsigned flags) {
    return queue("cuStreamBatchMemOp", stream, [&] {
        require(params && count && count <= 256 && flags == 0,
                "params is null, flags not 0, or not 1 to 256 operations");
        std::vector<Step> steps;
        for (unsigned i = 0; i < count; ++i)
            steps.push_back(stepOf(params[i]));
        return steps;
    });
}

// The attributes of streams. Only the priority has a meaning here: the stream's own priority.
bool isStreamAttribute(CUstreamAttrID attribute) {
    return attribute == CU_STREAM_ATTRIBUTE_ACCESS_POLICY_WINDOW ||
           attribute == CU_STREAM_ATTRIBUTE_SYNCHRONIZATION_POLICY ||
           attribute == CU_STREAM_ATTRIBUTE_PRIORITY ||
           attribute == CU_STREAM_ATTRIBUTE_MEM_SYNC_DOMAIN_MAP ||
           attribute == CU_STREAM_ATTRIBUTE_MEM_SYNC_DOMAIN;
}

} // namespace

SUNSTONE_EXPORT CUresult cuStreamWaitValue32(CUstream stream, CUdeviceptr address, cuuint32_t value,
                                             unsigned int flags) {
    return queue("cuStreamWaitValue32", stream,
                 [&] { return std::vector{waitStep(address, value, flags)}; });
}
SUNSTONE_EXPORT CUresult cuStreamWaitValue64(CUstream stream, CUdeviceptr address, cuuint64_t value,
                                             unsigned int flags) {
    return queue("cuStreamWaitValue64", stream,
                 [&] { return std::vector{waitStep<uint64_t>(address, value, flags)}; });
}
SUNSTONE_EXPORT CUresult cuStreamWriteValue32(CUstream stream, CUdeviceptr address,
                                              cuuint32_t value, unsigned int flags) {
    return queue("cuStreamWriteValue32", stream,
                 [&] { return std::vector{writeStep(address, value, flags)}; });
}
SUNSTONE_EXPORT CUresult cuStreamWriteValue64(CUstream stream, CUdeviceptr address,
                                              cuuint64_t value, unsigned int flags) {
    return queue("cuStreamWriteValue64", stream,
                 [&] { return std::vector{writeStep<uint64_t>(address, value, flags)}; });
}
SUNSTONE_EXPORT CUresult cuStreamBatchMemOp(CUstream stream, unsigned int count,
                                            CUstreamBatchMemOpParams* params, unsigned int flags) {
    return batch(stream, count, params, flags);
}

SUNSTONE_EXPORT CUresult cuStreamSetAttribute(CUstream stream, CUstreamAttrID attribute,
                                              const CUstreamAttrValue* value) {
    return guarded("cuStreamSetAttribute", {Needs::kContext, stream}, [&] {
        require(value && isStreamAttribute(attribute), "value is null, or no attribute of streams");
        const cpu::StreamPtr target = resolveStream(stream);
        if (attribute == CU_STREAM_ATTRIBUTE_PRIORITY)
            return target->setPriority(value->priority);
        std::array<unsigned char, sizeof *value> bytes;
        std::memcpy(bytes.data(), value, sizeof *value);
        target->keepAttribute(attribute, bytes);
    });
}
SUNSTONE_EXPORT CUresult cuStreamGetAttribute(CUstream stream, CUstreamAttrID attribute,
                                              CUstreamAttrValue* value) {
    return guarded("cuStreamGetAttribute", {Needs::kContext, stream}, [&] {
        require(value && isStreamAttribute(attribute), "value is null, or no attribute of streams");
        const cpu::StreamPtr target = resolveStream(stream);
        const auto bytes = target->attribute(attribute);
        std::memcpy(value, bytes.data(), sizeof *value);
        if (attribute == CU_STREAM_ATTRIBUTE_PRIORITY)
            value->priority = target->priority();
    });
}
SUNSTONE_EXPORT CUresult cuStreamCopyAttributes(CUstream to, CUstream from) {
    return guarded("cuStreamCopyAttributes",
                   {Needs::kContext, cpu::streams().isDefault(from) ? nullptr : to},
                   [&] { resolveStream(to)->copyAttributes(*resolveStream(from)); });
}

// The older forms, with the same parameters.
#undef cuStreamWaitValue32
#undef cuStreamWaitValue64
#undef cuStreamWriteValue32
#undef cuStreamWriteValue64
#undef cuStreamBatchMemOp
#ifdef CUDA_API_PER_THREAD_DEFAULT_STREAM
#define SUNSTONE_OLD(name) name##_ptsz
#define SUNSTONE_NEW(name) name##_v2_ptsz
#else
#define SUNSTONE_OLD(name) name
#define SUNSTONE_NEW(name) name##_v2
#endif
#define SUNSTONE_WORD_FORM(name, Word)                                                             \
    SUNSTONE_EXPORT CUresult SUNSTONE_OLD(name)(CUstream stream, CUdeviceptr address, Word value,  \
                                                unsigned int flags) {                              \
        return SUNSTONE_NEW(name)(stream, address, value, flags);                                  \
    }
SUNSTONE_WORD_FORM(cuStreamWaitValue32, cuuint32_t)
SUNSTONE_WORD_FORM(cuStreamWaitValue64, cuuint64_t)
SUNSTONE_WORD_FORM(cuStreamWriteValue32, cuuint32_t)
SUNSTONE_WORD_FORM(cuStreamWriteValue64, cuuint64_t)
SUNSTONE_EXPORT CUresult SUNSTONE_OLD(cuStreamBatchMemOp)(CUstream stream, unsigned int count,
                                                          CUstreamBatchMemOpParams* params,
                                                          unsigned int flags) {
    return batch(stream, count, params, flags);
}
