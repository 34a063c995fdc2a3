// SPDX-License-Identifier: Apache-2.0
// A footprint is a mask of 8x8 groups of texels. Its position counts in blocks of 8x8 groups. If
// the texels lie across the border of two blocks, the mask is rotated: its last dx columns (dy
// rows) stand for groups 8 further left (up). Group sizes have numbers; the requested size is that
// of the tile in the texture info. If 8x8 groups of that size do not cover the texels, a larger
// size is used and returned in the result. Source: OptiX API reference 7.4, section 3.1.2.151; the
// numbers of the group sizes are those of the OpenGL extension NV_shader_texture_footprint.
#include "texture/footprint.h"

#include <algorithm>
#include <vector>

namespace sunstone::texture {

namespace {

// log2 of width and height by number; 0 for a number without a size.
struct GroupSize {
    uint8_t width, height;
};
constexpr GroupSize kGroupSizes[16] = {{0, 0}, {1, 1}, {2, 1}, {2, 2}, {3, 2}, {3, 3},
                                       {4, 3}, {4, 4}, {0, 0}, {0, 0}, {0, 0}, {6, 6},
                                       {7, 6}, {7, 7}, {8, 7}, {8, 8}};

// The size of the tile, or the next larger one; the largest if it exceeds all.
unsigned requestedSize(uint32_t info) {
    const uint32_t width = info >> 20 & 15, height = info >> 16 & 15;
    for (unsigned number = 1; number < 15; ++number)
        if (kGroupSizes[number].width && kGroupSizes[number].width >= width &&
            kGroupSizes[number].height >= height)
            return number;
    return 15;
}

// A window of eight groups along one axis of an image with `count` groups.
class Window {
public:
    // groups: the groups in use, in any order.
    Window(std::vector<int> groups, int count, bool wraps) : count_(count) {
        std::sort(groups.begin(), groups.end());
        const int least = groups.front(), last = groups.back();
        // An aligned block, or a window that ends with the last group.
        first_ = least / 8 == last / 8 ? least / 8 * 8 : last - 7;
        fits = last - least < 8;
        if (fits || !wraps)
            return;
        // Groups right of the widest gap move to the other side, as groups below 0.
        size_t right = 1;
        for (size_t i = 1; i < groups.size(); ++i)
            if (groups[i] - groups[i - 1] > groups[right] - groups[right - 1])
                right = i;
        const int beyond = groups[right] - count;
        if (groups[right - 1] - beyond < 8) {
            first_ = groups[right - 1] - 7;
            fits = true;
        }
    }

    bool fits = false;
    uint32_t tile() const { return first_ > 0 ? uint32_t(first_ + 7) / 8 : 0; }
    uint32_t rotation() const { return uint32_t(int(tile()) * 8 - first_); }
    uint32_t bit(int group) const { // column or row of the mask
        const int at = group - first_ < 8 ? group : group - count_;
        return uint32_t(at - int(tile()) * 8) & 7;
    }

private:
    int first_ = 0; // may be negative
    int count_;
};

// Marks the groups of the record's texels on one level; false if 8x8 groups of this size do not
// cover them.
bool pack(const TexelRecord& record, const Image& image, const Texture& texture, unsigned number,
          uint32_t result[4]) {
    const GroupSize size = kGroupSizes[number];
    std::vector<int> columns, rows;
    for (unsigned i = 0; i < record.count; ++i)
        if (record.texels[i].image == &image) {
            columns.push_back(int(record.texels[i].x >> size.width));
            rows.push_back(int(record.texels[i].y >> size.height));
        }
    const auto wraps = [&](unsigned axis) {
        return texture.normalizedCoordinates && texture.address[axis] == Address::kWrap;
    };
    const Window x(columns, int((image.width - 1) >> size.width) + 1, wraps(0));
    const Window y(rows, int((image.height - 1) >> size.height) + 1, wraps(1));
    if (!x.fits || !y.fits)
        return false;
    uint64_t mask = 0;
    for (size_t i = 0; i < columns.size(); ++i)
        mask |= uint64_t(1) << (x.bit(columns[i]) + 8 * y.bit(rows[i]));
    const uint32_t level = uint32_t(&image - texture.images);
    result[0] = uint32_t(mask);
    result[1] = uint32_t(mask >> 32);
    result[2] = (y.tile() & 0xFFF) | x.rotation() << 16 | y.rotation() << 19;
    result[3] = (x.tile() & 0xFFF) | (level & 15) << 12;
    return true;
}

} // namespace

void footprint(uint64_t handle, uint32_t info, uint32_t form, const SampleOperands* operands,
               uint32_t coarse, uint32_t* singleLevel, uint32_t result[4]) {
    if (singleLevel)
        *singleLevel = 1;
    std::fill_n(result, 4, 0u);
    TexelRecord record;
    if (!recordTexels(handle, form, *operands, record) || record.count == 0)
        return;
    const auto [fine, other] =
        std::minmax_element(record.texels, record.texels + record.count,
                            [](const auto& a, const auto& b) { return a.image < b.image; });
    if (singleLevel)
        *singleLevel = fine->image == other->image;
    const Image& image = coarse ? *other->image : *fine->image;
    const Texture& texture = *findTexture(handle);
    const unsigned requested = requestedSize(info);
    for (unsigned number = requested; number < 16; ++number)
        if (kGroupSizes[number].width && pack(record, image, texture, number, result)) {
            result[2] |= (number == requested ? 0 : number) << 24;
            return;
        }
}

} // namespace sunstone::texture
