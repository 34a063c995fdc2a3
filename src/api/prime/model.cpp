// SPDX-License-Identifier: Apache-2.0
// Models (OptiX 6.0, module 5.33).
#include "api/prime/shell.h"

#include <cstring>

namespace sunstone::prime {
namespace {

enum ModelHintBit : unsigned { kAsync = 1, kMaskUpdate = 2, kUserTriangles = 4 };

engine::QueryArray arrayOf(const BufferDesc& desc) {
    return {desc.first(), desc.count(), desc.strideBytes(), desc.type == RTP_BUFFER_TYPE_HOST};
}

// Bytes from the first element to the end of the last.
uint64_t bytesOf(const BufferDesc& desc) {
    return desc.count() ? (desc.count() - 1) * desc.strideBytes() + desc.elementBytes() : 0;
}

// The checked inputs of an update.
engine::ModelTriangles trianglesOf(const Model& model) {
    const Context& context = *model.context;
    if (!model.vertices)
        fail(Code::kInvalidOperation,
             "the model has neither triangles nor instances: call rtpModelSetTriangles or "
             "rtpModelSetInstances");
    constexpr uint64_t kMost = uint64_t(1) << 31;
    engine::ModelTriangles triangles;
    triangles.vertices = arrayOf(*model.vertices);
    if (model.indices) {
        triangles.indices = arrayOf(*model.indices);
        triangles.hasMasks = model.indices->format == RTP_BUFFER_FORMAT_INDICES_INT3_MASK_INT;
        requireMemory(context, *model.indices, "indices", bytesOf(*model.indices), false);
    } else if (triangles.vertices.count % 3 != 0) {
        fail(Code::kInvalidValue, "vertices has a range of ", triangles.vertices.count,
             " elements, but without indices every three are a triangle");
    }
    requireMemory(context, *model.vertices, "vertices", bytesOf(*model.vertices), false);
    if (triangles.vertices.count > kMost || triangles.indices.count > kMost)
        fail(Code::kInvalidValue, "more than ", kMost, " vertices or triangles");
    return triangles;
}

struct Children {
    std::vector<std::shared_ptr<ModelUpdate>> updates;
    engine::QueryArray transforms;
};

Children childrenOf(const Model& model) {
    const Context& context = *model.context;
    const BufferDesc &instances = *model.instances, &transforms = *model.transforms;
    if (instances.count() != transforms.count())
        fail(Code::kInvalidValue, "instances has a range of ", instances.count(),
             " elements, transforms of ", transforms.count());
    if (instances.count() > uint64_t(1) << 28)
        fail(Code::kInvalidValue, "instances has more than 2^28 elements");
    requireMemory(context, instances, "instances", bytesOf(instances), false);
    requireMemory(context, transforms, "transforms", bytesOf(transforms), false);
    Children children;
    children.transforms = arrayOf(transforms);
    for (uint64_t i = 0; i < instances.count(); ++i) {
        RTPmodel handle;
        std::memcpy(&handle, static_cast<const uint8_t*>(instances.first()) + i * sizeof(handle),
                    sizeof(handle));
        const std::string name = message("instances[", i, "]");
        const std::shared_ptr<Model> child = modelOf(handle, name.c_str());
        if (child->context != model.context)
            fail(Code::kInvalidValue, name, " belongs to another context");
        const std::shared_ptr<ModelUpdate> update = child->update;
        if (!update)
            fail(Code::kInvalidOperation, name, " has not been updated");
        if (update->isInstances)
            fail(Code::kInvalidValue, name, " is a model of instances, which cannot be instanced");
        if (update->needsTriangles)
            fail(Code::kInvalidOperation, name, " is a copy whose triangles have not been set");
        if (update->callerTriangles != children.updates.emplace_back(update)->callerTriangles ||
            update->callerTriangles != children.updates.front()->callerTriangles)
            fail(Code::kInvalidValue, name,
                 " has another RTP_BUILDER_PARAM_USE_CALLER_TRIANGLES than instances[0]");
    }
    return children;
}

// Starts the work of an update, which stores the structure. Unless it is asynchronous, waits for
// the work without holding the lock.
void start(Model& model, unsigned hints, std::shared_ptr<ModelUpdate> update,
           std::unique_lock<std::mutex>& lock, std::function<engine::StructurePtr()> work) {
    ModelUpdate* const to = update.get(); // the completion's owner waits for it
    const ContextPtr context = model.context;
    Context::Work prepared = context->prepare(
        context->place(), [keep = std::weak_ptr<ModelUpdate>(update), to, work = std::move(work)] {
            engine::StructurePtr structure = work();
            if (const auto alive = keep.lock())
                to->structure = std::move(structure);
        });
    update->completion = prepared.completion;
    model.update = update;
    if (hints & kAsync)
        return context->queue.push(std::move(prepared.body));
    lock.unlock();
    context->run(prepared);
    update->wait();
}

void updateInstances(Model& model, unsigned hints, std::unique_lock<std::mutex>& lock) {
    if (hints & (kMaskUpdate | kUserTriangles))
        fail(Code::kInvalidValue, "hints are of models of triangles, but the model has instances");
    Children children = childrenOf(model);
    auto update = std::make_shared<ModelUpdate>();
    update->isInstances = true;
    start(model, hints, update, lock,
          [device = model.context->device, children = std::move(children)]() {
              engine::ModelInstances instances;
              instances.transforms = children.transforms;
              for (const auto& child : children.updates)
                  instances.models.push_back(child->wait());
              return device->build(instances);
          });
}

void updateMasks(Model& model, unsigned hints, std::unique_lock<std::mutex>& lock) {
    const engine::ModelTriangles triangles = trianglesOf(model);
    if (!model.update || model.update->isInstances || model.update->needsTriangles)
        fail(Code::kInvalidOperation,
             "RTP_MODEL_HINT_MASK_UPDATE needs an earlier update of the triangles");
    if (!triangles.hasMasks)
        fail(Code::kInvalidValue, "RTP_MODEL_HINT_MASK_UPDATE needs indices of format "
                                  "RTP_BUFFER_FORMAT_INDICES_INT3_MASK_INT");
    if (triangles.triangles() != model.update->triangles)
        fail(Code::kInvalidValue, "the model has ", model.update->triangles,
             " triangles, the new masks are ", triangles.triangles());
    auto update = std::make_shared<ModelUpdate>();
    update->callerTriangles = model.update->callerTriangles;
    update->triangles = triangles.triangles();
    start(model, hints, update, lock,
          [device = model.context->device, before = model.update, triangles]() {
              return device->withMasks(before->wait(), triangles);
          });
}

void updateTriangles(Model& model, unsigned hints, std::unique_lock<std::mutex>& lock) {
    const engine::ModelTriangles triangles = trianglesOf(model);
    auto update = std::make_shared<ModelUpdate>();
    update->callerTriangles = model.callerTriangles;
    update->triangles = triangles.triangles();
    if (hints & kUserTriangles) {
        if (!model.update || !model.update->needsTriangles)
            fail(Code::kInvalidOperation,
                 "RTP_MODEL_HINT_USER_TRIANGLES_AFTER_COPY_SET: the model is no copy that lacks "
                 "its triangles");
        if (triangles.triangles() != model.update->triangles)
            fail(Code::kInvalidValue, "the copied model has ", model.update->triangles,
                 " triangles, those set are ", triangles.triangles());
    }
    start(model, hints, update, lock,
          [device = model.context->device, triangles]() { return device->build(triangles); });
}

template <class T>
T readParameter(RTPsize size, const void* ptr) {
    if (size != sizeof(T))
        fail(Code::kInvalidValue, "size = ", size, ", but the parameter has ", sizeof(T), " bytes");
    T value;
    std::memcpy(&value, ptr, sizeof(value));
    return value;
}

} // namespace

extern "C" RTPresult RTPAPI rtpModelCreate(RTPcontext context, RTPmodel* model) {
    return guarded(contexts().find(context), "rtpModelCreate", [&] {
        auto object = std::make_shared<Model>();
        object->context = contextOf(context);
        requireNonNull(model, "model");
        *model = static_cast<RTPmodel>(models().add(object));
    });
}

extern "C" RTPresult RTPAPI rtpModelGetContext(RTPmodel model, RTPcontext* context) {
    return guarded(peekContext(models(), model), "rtpModelGetContext",
                   [&] { giveContext(*modelOf(model, "model"), context); });
}

extern "C" RTPresult RTPAPI rtpModelSetTriangles(RTPmodel model, RTPbufferdesc indices,
                                                 RTPbufferdesc vertices) {
    return guarded(peekContext(models(), model), "rtpModelSetTriangles", [&] {
        const auto object = modelOf(model, "model");
        std::lock_guard lock(object->context->mutex);
        std::optional<BufferDesc> newIndices;
        if (indices)
            newIndices = usableDesc(
                *object->context, indices, "indices",
                {RTP_BUFFER_FORMAT_INDICES_INT3, RTP_BUFFER_FORMAT_INDICES_INT3_MASK_INT});
        object->vertices =
            usableDesc(*object->context, vertices, "vertices",
                       {RTP_BUFFER_FORMAT_VERTEX_FLOAT3, RTP_BUFFER_FORMAT_VERTEX_FLOAT4});
        object->indices = std::move(newIndices);
        object->instances.reset();
        object->transforms.reset();
    });
}

extern "C" RTPresult RTPAPI rtpModelSetInstances(RTPmodel model, RTPbufferdesc instances,
                                                 RTPbufferdesc transforms) {
    return guarded(peekContext(models(), model), "rtpModelSetInstances", [&] {
        const auto object = modelOf(model, "model");
        std::lock_guard lock(object->context->mutex);
        const BufferDesc newInstances = usableDesc(*object->context, instances, "instances",
                                                   {RTP_BUFFER_FORMAT_INSTANCE_MODEL});
        if (newInstances.type != RTP_BUFFER_TYPE_HOST)
            fail(Code::kInvalidValue, "instances is not of type RTP_BUFFER_TYPE_HOST");
        object->transforms = usableDesc(
            *object->context, transforms, "transforms",
            {RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x4, RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x3});
        object->instances = newInstances;
        object->indices.reset();
        object->vertices.reset();
    });
}

extern "C" RTPresult RTPAPI rtpModelUpdate(RTPmodel model, unsigned hints) {
    return guarded(peekContext(models(), model), "rtpModelUpdate", [&] {
        const auto object = modelOf(model, "model");
        const unsigned bits = hintBits(hints, 0x2000, kAsync | kMaskUpdate | kUserTriangles);
        std::unique_lock lock(object->context->mutex);
        if (object->instances)
            updateInstances(*object, bits, lock);
        else if ((bits & kMaskUpdate) && !(bits & kUserTriangles))
            updateMasks(*object, bits, lock);
        else
            updateTriangles(*object, bits, lock);
    });
}

extern "C" RTPresult RTPAPI rtpModelFinish(RTPmodel model) {
    return guarded(peekContext(models(), model), "rtpModelFinish", [&] {
        const auto object = modelOf(model, "model");
        std::unique_lock lock(object->context->mutex);
        const std::shared_ptr<ModelUpdate> update = object->update;
        lock.unlock();
        if (update)
            update->wait();
    });
}

extern "C" RTPresult RTPAPI rtpModelGetFinished(RTPmodel model, int* isFinished) {
    return guarded(peekContext(models(), model), "rtpModelGetFinished", [&] {
        const auto object = modelOf(model, "model");
        requireNonNull(isFinished, "isFinished");
        std::lock_guard lock(object->context->mutex);
        *isFinished = !object->update || object->update->isDone();
    });
}

extern "C" RTPresult RTPAPI rtpModelCopy(RTPmodel model, RTPmodel srcModel) {
    return guarded(peekContext(models(), model), "rtpModelCopy", [&] {
        const auto object = modelOf(model, "model");
        const auto source = modelOf(srcModel, "srcModel");
        if (object == source)
            fail(Code::kInvalidValue, "model and srcModel are the same");
        std::unique_lock lock(source->context->mutex);
        const std::shared_ptr<ModelUpdate> from = source->update;
        const std::shared_ptr<engine::QueryDevice> owner = source->context->device;
        lock.unlock();
        if (!from)
            fail(Code::kInvalidOperation, "srcModel has not been updated");
        if (from->isInstances)
            fail(Code::kInvalidValue, "srcModel has instances: only triangles can be copied");
        if (from->needsTriangles)
            fail(Code::kInvalidOperation, "srcModel is a copy whose triangles have not been set");
        const engine::StructurePtr structure = from->wait();
        std::unique_lock mine(object->context->mutex);
        auto update = std::make_shared<ModelUpdate>();
        update->callerTriangles = object->callerTriangles;
        update->needsTriangles = from->callerTriangles && object->callerTriangles;
        update->triangles = from->triangles;
        const std::shared_ptr<engine::QueryDevice> device = object->context->device;
        object->indices.reset();
        object->vertices.reset();
        object->instances.reset();
        object->transforms.reset();
        start(*object, 0, update, mine, [&]() -> engine::StructurePtr {
            return device == owner ? structure : device->copy(structure, *owner);
        });
    });
}

extern "C" RTPresult RTPAPI rtpModelSetBuilderParameter(RTPmodel model_api, RTPbuilderparam param,
                                                        RTPsize size, const void* ptr) {
    return guarded(peekContext(models(), model_api), "rtpModelSetBuilderParameter", [&] {
        const auto object = modelOf(model_api, "model_api");
        requireNonNull(ptr, "ptr");
        std::lock_guard lock(object->context->mutex);
        if (param == RTP_BUILDER_PARAM_CHUNK_SIZE) {
            // Programs pass an int, too, because -1 is documented.
            object->chunkSize = size == sizeof(int) ? RTPsize(readParameter<int>(size, ptr))
                                                    : readParameter<RTPsize>(size, ptr);
        } else if (param == RTP_BUILDER_PARAM_USE_CALLER_TRIANGLES) {
            const int value = readParameter<int>(size, ptr);
            if (value != 0 && value != 1)
                fail(Code::kInvalidValue, "RTP_BUILDER_PARAM_USE_CALLER_TRIANGLES = ", value,
                     " is neither 0 nor 1");
            object->callerTriangles = value != 0;
        } else {
            fail(Code::kInvalidValue, "param = 0x", std::hex, unsigned(param), " is unknown");
        }
    });
}

extern "C" RTPresult RTPAPI rtpModelDestroy(RTPmodel model) {
    return guarded(peekContext(models(), model), "rtpModelDestroy", [&] {
        const auto object = modelOf(model, "model");
        models().remove(model);
        for (const std::shared_ptr<Query>& query :
             queries().removeIf([&](const Query& q) { return q.model == object; }))
            finishQuietly(completionOf(*query));
        std::unique_lock lock(object->context->mutex);
        const std::shared_ptr<ModelUpdate> update = object->update;
        lock.unlock();
        try {
            if (update)
                update->wait();
        } catch (const Error& error) {
            log(LogLevel::kWarning, "prime", error.what());
        }
    });
}

} // namespace sunstone::prime
