// SPDX-License-Identifier: Apache-2.0
// Queries (OptiX 6.0, module 5.34).
#include "api/prime/cuda_library.h"
#include "api/prime/shell.h"
#include "base/readable.h"

namespace sunstone::prime {
namespace {

enum QueryHintBit : unsigned { kAsync = 1, kWatertight = 2 };

bvh::RayFormat rayFormatOf(RTPbufferformat format) {
    switch (format) {
    case RTP_BUFFER_FORMAT_RAY_ORIGIN_DIRECTION:
        return bvh::RayFormat::kOriginDirection;
    case RTP_BUFFER_FORMAT_RAY_ORIGIN_MASK_DIRECTION_TMAX:
        return bvh::RayFormat::kOriginMaskDirectionTmax;
    default:
        return bvh::RayFormat::kOriginTminDirectionTmax;
    }
}

bvh::HitFormat hitFormatOf(RTPbufferformat format) {
    switch (format) {
    case RTP_BUFFER_FORMAT_HIT_BITMASK:
        return bvh::HitFormat::kBit;
    case RTP_BUFFER_FORMAT_HIT_T:
        return bvh::HitFormat::kT;
    case RTP_BUFFER_FORMAT_HIT_T_TRIID:
        return bvh::HitFormat::kTTriangle;
    case RTP_BUFFER_FORMAT_HIT_T_TRIID_U_V:
        return bvh::HitFormat::kTTriangleUv;
    case RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID:
        return bvh::HitFormat::kTTriangleInstance;
    default:
        return bvh::HitFormat::kTTriangleInstanceUv;
    }
}

engine::TraceRequest requestOf(const Query& query, const engine::StructurePtr& structure) {
    const BufferDesc &rays = *query.rays, &hits = *query.hits;
    const Context& context = *query.context;
    engine::TraceRequest request;
    request.structure = structure;
    request.any = query.type == RTP_QUERY_TYPE_ANY;
    request.stream = query.stream;
    request.count = rays.count();
    request.rayFormat = rayFormatOf(rays.format);
    request.hitFormat = hitFormatOf(hits.format);
    request.rays = rays.first();
    request.raysOnHost = rays.type == RTP_BUFFER_TYPE_HOST;
    request.hitsOnHost = hits.type == RTP_BUFFER_TYPE_HOST;
    requireMemory(context, rays, "rays", request.count * rays.elementBytes(), false);
    BufferDesc bytes = hits;
    uint64_t size = request.count * hits.elementBytes();
    if (request.hitFormat == bvh::HitFormat::kBit) {
        request.firstBit = uint32_t(hits.begin % 8);
        bytes.buffer = hits.addressAt(hits.begin / 8);
        size = request.count ? (request.firstBit + request.count + 7) / 8 : 0;
    }
    request.hits = bytes.first();
    requireMemory(context, bytes, "hits", size, true);
    return request;
}

void requireNoCapture(const Query& query) {
    CUstreamCaptureStatus status = CU_STREAM_CAPTURE_STATUS_NONE;
    if (query.context->type == RTP_CONTEXT_TYPE_CUDA &&
        cuda().streamIsCapturing(static_cast<CUstream>(query.stream), &status) == CUDA_SUCCESS &&
        status != CU_STREAM_CAPTURE_STATUS_NONE)
        fail(Code::kInvalidOperation, "the query's stream is being captured into a graph");
}

// The model's structure after its update.
engine::StructurePtr structureOf(const Query& query, std::unique_lock<std::mutex>& lock) {
    const std::shared_ptr<ModelUpdate> update = query.model->update;
    if (!update)
        fail(Code::kInvalidOperation, "the model has not been updated: call rtpModelUpdate");
    if (update->needsTriangles)
        fail(Code::kInvalidOperation,
             "the model is a copy whose triangles have not been set: call rtpModelSetTriangles, "
             "then rtpModelUpdate with RTP_MODEL_HINT_USER_TRIANGLES_AFTER_COPY_SET");
    lock.unlock();
    engine::StructurePtr structure = update->wait();
    lock.lock();
    return structure;
}

void requireRanges(const Query& query) {
    if (!query.rays || !query.hits)
        fail(Code::kInvalidOperation, "the query has no ", query.rays ? "hits" : "rays",
             ": call rtpQuerySet", query.rays ? "Hits" : "Rays");
    if (query.rays->count() != query.hits->count())
        fail(Code::kInvalidValue, "rays has a range of ", query.rays->count(),
             " elements, hits of ", query.hits->count());
}

void execute(const std::shared_ptr<Query>& query, bool asynchronous) {
    std::unique_lock lock(query->context->mutex);
    requireRanges(*query);
    const engine::StructurePtr structure = structureOf(*query, lock);
    requireRanges(*query); // another thread may have changed the ranges
    requireNoCapture(*query);
    const engine::TraceRequest request = requestOf(*query, structure);
    const ContextPtr context = query->context;
    const std::shared_ptr<engine::QueryDevice> device = context->device;
    const Context::Place place = context->place();
    const engine::CompletionPtr before = query->completion;
    lock.unlock();
    finishQuietly(before);
    engine::CompletionPtr completion;
    if (context->type == RTP_CONTEXT_TYPE_CPU) {
        Context::Work work =
            context->prepare(place, [device, request] { device->trace(request)->wait(); });
        completion = work.completion;
        if (asynchronous)
            context->queue.push(std::move(work.body));
        else
            context->run(work);
    } else {
        CudaScope scope(place.cudaContext);
        completion = device->trace(request);
    }
    if (!asynchronous)
        return completion->wait();
    lock.lock();
    query->completion = completion;
}

} // namespace

extern "C" RTPresult RTPAPI rtpQueryCreate(RTPmodel model, RTPquerytype queryType,
                                           RTPquery* query) {
    return guarded(peekContext(models(), model), "rtpQueryCreate", [&] {
        auto object = std::make_shared<Query>();
        object->model = modelOf(model, "model");
        object->context = object->model->context;
        requireNonNull(query, "query");
        if (queryType != RTP_QUERY_TYPE_ANY && queryType != RTP_QUERY_TYPE_CLOSEST)
            fail(Code::kInvalidValue, "queryType = 0x", std::hex, unsigned(queryType),
                 " is neither RTP_QUERY_TYPE_ANY nor RTP_QUERY_TYPE_CLOSEST");
        object->type = queryType;
        *query = static_cast<RTPquery>(queries().add(object));
    });
}

extern "C" RTPresult RTPAPI rtpQueryGetContext(RTPquery query, RTPcontext* context) {
    return guarded(peekContext(queries(), query), "rtpQueryGetContext",
                   [&] { giveContext(*queryOf(query), context); });
}

extern "C" RTPresult RTPAPI rtpQuerySetRays(RTPquery query, RTPbufferdesc rays) {
    return guarded(peekContext(queries(), query), "rtpQuerySetRays", [&] {
        const auto object = queryOf(query);
        std::lock_guard lock(object->context->mutex);
        object->rays = usableDesc(*object->context, rays, "rays",
                                  {RTP_BUFFER_FORMAT_RAY_ORIGIN_DIRECTION,
                                   RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX,
                                   RTP_BUFFER_FORMAT_RAY_ORIGIN_MASK_DIRECTION_TMAX});
    });
}

extern "C" RTPresult RTPAPI rtpQuerySetHits(RTPquery query, RTPbufferdesc hits) {
    return guarded(peekContext(queries(), query), "rtpQuerySetHits", [&] {
        const auto object = queryOf(query);
        std::lock_guard lock(object->context->mutex);
        object->hits = usableDesc(*object->context, hits, "hits",
                                  {RTP_BUFFER_FORMAT_HIT_BITMASK, RTP_BUFFER_FORMAT_HIT_T,
                                   RTP_BUFFER_FORMAT_HIT_T_TRIID, RTP_BUFFER_FORMAT_HIT_T_TRIID_U_V,
                                   RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID,
                                   RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V});
    });
}

extern "C" RTPresult RTPAPI rtpQueryExecute(RTPquery query, unsigned hints) {
    return guarded(peekContext(queries(), query), "rtpQueryExecute", [&] {
        const auto object = queryOf(query);
        execute(object, hintBits(hints, 0x4000, kAsync | kWatertight) & kAsync);
    });
}

extern "C" RTPresult RTPAPI rtpQueryFinish(RTPquery query) {
    return guarded(peekContext(queries(), query), "rtpQueryFinish", [&] {
        const auto object = queryOf(query);
        std::unique_lock lock(object->context->mutex);
        const engine::CompletionPtr completion = object->completion;
        lock.unlock();
        if (completion)
            completion->wait();
    });
}

extern "C" RTPresult RTPAPI rtpQueryGetFinished(RTPquery query, int* isFinished) {
    return guarded(peekContext(queries(), query), "rtpQueryGetFinished", [&] {
        const auto object = queryOf(query);
        requireNonNull(isFinished, "isFinished");
        std::lock_guard lock(object->context->mutex);
        *isFinished = !object->completion || object->completion->isDone();
    });
}

extern "C" RTPresult RTPAPI rtpQuerySetCudaStream(RTPquery query, cudaStream_t stream) {
    return guarded(peekContext(queries(), query), "rtpQuerySetCudaStream", [&] {
        const auto object = queryOf(query);
        if (object->context->type != RTP_CONTEXT_TYPE_CUDA)
            fail(Code::kInvalidValue, "the query's context is not of type RTP_CONTEXT_TYPE_CUDA");
        constexpr uintptr_t kLastDefaultStream = 2; // legacy and per-thread
        if (uintptr_t(stream) > kLastDefaultStream) {
            // Drivers read the memory before they check whether it is a stream.
            CUcontext of = nullptr;
            if ((cuda().readsHandles && !isReadable(stream, 64)) ||
                cuda().streamGetCtx(stream, &of) != CUDA_SUCCESS)
                fail(Code::kInvalidValue, "stream = ", static_cast<const void*>(stream),
                     " is not a live CUDA stream");
        }
        std::lock_guard lock(object->context->mutex);
        object->stream = stream;
    });
}

extern "C" RTPresult RTPAPI rtpQueryDestroy(RTPquery query) {
    return guarded(peekContext(queries(), query), "rtpQueryDestroy", [&] {
        const auto object = queryOf(query);
        queries().remove(query);
        finishQuietly(completionOf(*object));
    });
}

} // namespace sunstone::prime
