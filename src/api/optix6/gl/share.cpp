// SPDX-License-Identifier: Apache-2.0
// Buffer objects. images.cpp has images.
#include "api/optix6/gl/share.h"

#include <algorithm>

namespace sunstone::optix6::gl {

namespace {

// Binds a buffer object to the target that no drawing reads.
class Binding {
public:
    Binding(const Functions& gl, unsigned id)
        : gl_(gl), before_(unsigned(gl.integer(kArrayBufferBinding))) {
        gl.BindBuffer(kArrayBuffer, id);
    }
    ~Binding() { gl_.BindBuffer(kArrayBuffer, before_); }
    Binding(const Binding&) = delete;

    int parameter(unsigned name) const {
        int value = 0;
        gl_.GetBufferParameteriv(kArrayBuffer, name, &value);
        return value;
    }
    uint64_t bytes() const {
        long long size = 0;
        if (gl_.version >= 32 && gl_.GetBufferParameteri64v)
            gl_.GetBufferParameteri64v(kArrayBuffer, kBufferSize, &size);
        else
            size = parameter(kBufferSize);
        return uint64_t(size);
    }
    bool isMapped() const {
        if (!parameter(kBufferMapped))
            return false;
        return gl_.version < 44 || !(parameter(kBufferAccessFlags) & kMapPersistentBit);
    }
    bool takesData() const {
        return gl_.version < 44 || !parameter(kBufferImmutableStorage) ||
               (parameter(kBufferStorageFlags) & kDynamicStorageBit);
    }

private:
    const Functions& gl_;
    const unsigned before_;
};

void requireObject(const Functions& gl, const Buffer& buffer) {
    if (!gl.IsBuffer(buffer.glBuffer))
        refuse(RT_ERROR_INVALID_VALUE, "glId = ", buffer.glBuffer,
               " is not a buffer of the current OpenGL context");
}

void requireRoom(const Binding& bound, const Buffer& buffer) {
    if (bound.isMapped())
        refuse(RT_ERROR_INVALID_VALUE, "OpenGL buffer ", buffer.glBuffer, " is mapped by OpenGL");
    if (bound.bytes() < buffer.bytes())
        refuse(RT_ERROR_INVALID_VALUE, "OpenGL buffer ", buffer.glBuffer, " has ", bound.bytes(),
               " bytes, fewer than the ", buffer.bytes(), " of the buffer that shares it");
}

// For storage without uploads from the host: copies through a buffer object that allows them.
void uploadByCopy(const Functions& gl, const void* data, ptrdiff_t bytes) {
    if (!gl.CopyBufferSubData || !gl.GenBuffers || !gl.DeleteBuffers || !gl.BufferData)
        refuse(RT_ERROR_NOT_SUPPORTED, "the OpenGL buffer has immutable storage");
    const auto before = unsigned(gl.integer(kCopyReadBufferBinding));
    unsigned other = 0;
    gl.GenBuffers(1, &other);
    gl.BindBuffer(kCopyReadBuffer, other);
    gl.BufferData(kCopyReadBuffer, bytes, data, kStreamCopy);
    gl.CopyBufferSubData(kCopyReadBuffer, kArrayBuffer, 0, 0, bytes);
    gl.BindBuffer(kCopyReadBuffer, before);
    gl.DeleteBuffers(1, &other);
}

void download(const Functions& gl, Buffer& buffer) {
    requireObject(gl, buffer);
    const Binding bound(gl, buffer.glBuffer);
    requireRoom(bound, buffer);
    gl.GetBufferSubData(kArrayBuffer, 0, ptrdiff_t(buffer.bytes()), buffer.data());
    buffer.noteChange();
}

void upload(const Functions& gl, const Buffer& buffer) {
    requireObject(gl, buffer);
    const Binding bound(gl, buffer.glBuffer);
    requireRoom(bound, buffer);
    if (bound.takesData())
        gl.BufferSubData(kArrayBuffer, 0, ptrdiff_t(buffer.bytes()), buffer.data());
    else
        uploadByCopy(gl, buffer.data(), ptrdiff_t(buffer.bytes()));
}

template <class T>
std::vector<std::shared_ptr<T>> liveOf(std::vector<Ref<T>>& list) {
    list.erase(std::remove_if(list.begin(), list.end(), [](const auto& r) { return r.expired(); }),
               list.end());
    std::vector<std::shared_ptr<T>> live;
    for (const Ref<T>& ref : list)
        if (std::shared_ptr<T> object = ref.lock())
            live.push_back(std::move(object));
    return live;
}

// Whether launches copy the buffer's elements. Mapped buffers belong to the host until unmapped.
bool isShared(const Buffer& buffer) {
    return buffer.isGlRegistered && !buffer.isMapped() && buffer.data();
}

} // namespace

void check(const Buffer& buffer) {
    requireObject(current(), buffer);
}

void download(Buffer& buffer) {
    download(current(), buffer);
}

void upload(const Buffer& buffer) {
    upload(current(), buffer);
}

const Functions& Share::gl() {
    if (!gl_)
        gl_ = current();
    return *gl_;
}

namespace {

// Whether some program reads a variable that has the object as its value.
bool isRead(const Context& context, const Object& object) {
    for (const Ref<Variable>& ref : context.variables)
        if (const std::shared_ptr<Variable> variable = ref.lock();
            variable && !variable->users.empty() && variable->object.lock().get() == &object)
            return true;
    return false;
}

// Whether programs, builds or textures may read the buffer. Programs use objects with ids by
// number; builds and textures read buffers of other objects.
bool isReached(const Context& context, const Buffer& buffer) {
    return buffer.id != 0 || buffer.isUsedByObjects || isRead(context, buffer);
}
bool isReached(const Context& context, const TextureSampler& sampler) {
    return sampler.id != 0 || isRead(context, sampler);
}

} // namespace

Share::Share(Context& context) : context_(context) {
    // After a change of structure only the launch determines which variables programs read.
    const bool all = context_.structureChanged;
    for (const std::shared_ptr<Buffer>& buffer : liveOf(context_.glBuffers))
        if (isShared(*buffer) && (all || isReached(context_, *buffer))) {
            download(gl(), *buffer);
            fetched_.insert(buffer.get());
        }
    for (const std::shared_ptr<TextureSampler>& sampler : liveOf(context_.glSamplers))
        if (sampler->gl->isRegistered && (all || isReached(context_, *sampler)))
            gl::fetch(gl(), *sampler);
}

void Share::fetch(const PostProcessingStage& stage) {
    for (const std::shared_ptr<Variable>& variable : stage.scope.list()) {
        const std::shared_ptr<Object> object = variable->object.lock();
        if (!object || object->kind != Kind::kBuffer)
            continue;
        auto& buffer = static_cast<Buffer&>(*object);
        if (!isShared(buffer))
            continue;
        if (fetched_.insert(&buffer).second)
            download(gl(), buffer);
        ofStages_.insert(&buffer);
    }
}

void Share::giveBack() {
    for (const std::shared_ptr<Buffer>& buffer : liveOf(context_.glBuffers))
        if (isShared(*buffer) && buffer->typeBits() != RT_BUFFER_INPUT &&
            (ofStages_.count(buffer.get()) || isReached(context_, *buffer)))
            upload(gl(), *buffer);
}

} // namespace sunstone::optix6::gl
