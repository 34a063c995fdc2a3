// SPDX-License-Identifier: Apache-2.0
// Buffers. The memory is the device's, which on a CPU is the host's.
#pragma once

#include "api/optix6/object.h"
#include "devlib/classic.h"

#include <vector>

namespace sunstone::optix6 {

unsigned bytesOf(RTformat format); // of an element; 0 of user formats and unknown ones

class Buffer : public Object {
public:
    static constexpr Kind kKind = Kind::kBuffer;
    Buffer(const std::shared_ptr<Context>& context, unsigned description_)
        : Object(kKind, context), description(description_) {
        updateView();
    }

    void setFormat(RTformat format);
    void setElementSize(RTsize size);
    void setSize(unsigned dimensions, const RTsize* extents);
    void setMipLevels(unsigned count);
    // Adopts memory of the application; null: memory of its own again.
    void setMemory(void* memory);
    void* map(unsigned flags, unsigned level);
    void unmap(unsigned level);
    bool isMapped() const;
    // Throws RT_ERROR_INVALID_CONTEXT if something is missing.
    void validate() const;

    uint8_t* data() const { return view_.data; }
    uint64_t levelOffset(unsigned level) const;
    // Of a dimension at a level; 1 beyond the dimensionality.
    uint64_t extent(unsigned dimension, unsigned level) const;
    uint64_t elements() const { return view_.size[0] * view_.size[1] * view_.size[2]; }
    uint64_t bytes() const;
    const devlib::BufferView& view() const { return view_; }
    unsigned typeBits() const { return description & 0x13; }

    const unsigned description; // RTbuffertype | RTbufferflag
    RTformat format = RT_FORMAT_UNKNOWN;
    unsigned dimensions = 0; // 0: no size was set
    unsigned mipLevels = 1;
    int id = 0;

private:
    struct Release {
        void operator()(uint8_t* memory) const;
    };
    void requireUnmapped() const;
    void allocate();
    void updateView();
    uint64_t levelElements(unsigned level) const;

    uint64_t extents_[3] = {0, 0, 0};
    uint32_t elementBytes_ = 0;
    std::unique_ptr<uint8_t[], Release> storage_;
    void* adopted_ = nullptr;
    std::vector<bool> mapped_{false}; // by level
    devlib::BufferView view_{};
};

} // namespace sunstone::optix6
