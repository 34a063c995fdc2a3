// SPDX-License-Identifier: Apache-2.0
// Buffers. The host and programs share their memory.
#pragma once

#include "api/optix6/memory.h"
#include "api/optix6/object.h"
#include "api/optix6/progressive/stream.h"
#include "devlib/classic.h"

#include <set>
#include <string_view>
#include <vector>

namespace sunstone::optix6 {

unsigned bytesOf(RTformat format); // of an element; 0 of user formats and unknown ones
// The enumerator; of other values the number.
std::string nameOf(RTformat format);

class Variable;

class Buffer : public Object {
public:
    static constexpr Kind kKind = Kind::kBuffer;
    Buffer(const std::shared_ptr<Context>& context, unsigned description);
    ~Buffer() override;

    void setFormat(RTformat format);
    void setElementSize(RTsize size);
    void setSize(unsigned dimensions, const RTsize* extents);
    void setMipLevels(unsigned count);
    // Adopts memory of the application; null: memory of its own again.
    void setMemory(void* memory);
    // Throws Failure if the application has a pointer to the elements on their device.
    void requireMovable() const;
    // Moves the elements to another device. The buffer must be movable and not mapped.
    void moveTo(const std::shared_ptr<engine::Backend>& backend);
    void* map(unsigned flags, unsigned level);
    void unmap(unsigned level);
    bool isMapped() const;
    // Reads all bytes of all levels, on any device.
    void read(void* to) const;
    void write(std::string_view all);
    // The property that programs need and the buffer lacks; empty if it is complete.
    std::string missing() const;
    // Throws RT_ERROR_INVALID_CONTEXT if a property is missing.
    void validate() const;

    uint8_t* data() const { return view().data; }
    uint64_t levelOffset(unsigned level) const;
    // The size of a dimension at a level; 1 beyond the dimensionality.
    uint64_t extent(unsigned dimension, unsigned level) const;
    uint64_t bytes() const;
    const devlib::BufferView& view() const {
        return *static_cast<const devlib::BufferView*>(view_.get());
    }
    // Counts the changes that the host makes to the elements.
    uint64_t version() const { return version_; }
    // Whether elements may change without a call: launches or the application's kernels write them.
    bool changesUnseen() const {
        return (description & RT_BUFFER_OUTPUT) || hasPointer_ || glBuffer != 0;
    }
    void notePointer() { hasPointer_ = true; }
    void noteChange() { ++version_; }
    unsigned typeBits() const { return description & 0x13; }
    // Whether programs access both buffers in the same way.
    bool hasShapeOf(const Buffer& other) const;
    // The variables that have the buffer as their value.
    void addHolder(const Variable& variable) { holders_.insert(&variable); }
    void removeHolder(const Variable& variable) { holders_.erase(&variable); }
    bool hasHolders() const { return !holders_.empty(); }
    // For errors: the names of these variables, as " of variable \"x\""; empty without variables.
    std::string variableNames() const;

    const unsigned description;           // RTbuffertype | RTbufferflag
    const std::unique_ptr<Stream> stream; // of RT_BUFFER_PROGRESSIVE_STREAM alone
    RTformat format = RT_FORMAT_UNKNOWN;
    unsigned dimensions = 0; // 0: no size was set
    unsigned mipLevels = 1;
    int id = 0;
    // The buffer object of OpenGL that has the same elements (gl/share.h); 0: none.
    unsigned glBuffer = 0;
    bool isGlRegistered = false;
    bool isUsedByObjects = false; // by geometry triangles or a texture sampler, now or before
    bool isRegistered() const { return glBuffer == 0 || isGlRegistered; }
    // Throws RT_ERROR_INVALID_VALUE if only OpenGL may use the elements.
    void requireRegistered() const;

private:
    engine::Backend& backend() const { return *backend_; }
    bool isForeign() const;
    void requireUnmapped() const;
    void requireLevels(unsigned count) const;
    void noteMapped();
    void allocate();
    void updateView();
    uint64_t levelElements(unsigned level) const;

    uint64_t extents_[3] = {0, 0, 0};
    uint32_t elementBytes_ = 0;
    std::shared_ptr<engine::Backend> backend_;
    SharedMemory storage_, view_;
    void* adopted_ = nullptr;
    bool hasPointer_ = false; // the application has a device pointer
    std::set<const Variable*> holders_;
    uint64_t version_ = 0;
    std::vector<bool> mapped_{false};                // by level
    bool wasWritten_ = false;                        // by the host, since the last upload to OpenGL
    std::vector<std::unique_ptr<uint8_t[]>> copies_; // of mapped levels of foreign memory
};

} // namespace sunstone::optix6
