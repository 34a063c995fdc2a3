// SPDX-License-Identifier: Apache-2.0
// Denoises large images tile by tile, to save memory. C++ only; needs the stubs or another
// definition of optixDenoiserInvoke. Source: OptiX API reference 7.4, sections 3.14.2.9 to
// 3.14.2.11, 5.38, 6.8.
//
// A tile's input is its output plus `overlap` pixels on each side, except at the edges of the
// image. All inputs have the same size, min(tile + 2 * overlap, image). The first input starts at
// the image's edge and yields tile + overlap pixels; the next ones yield `tile` pixels each. The
// last input is moved back into the image, so its first output pixel lies further inside it.
#ifndef SUNSTONE_OPTIX7_OPTIX_DENOISER_TILING_H
#define SUNSTONE_OPTIX7_OPTIX_DENOISER_TILING_H

#include "optix_host.h"

#include <vector>

/** One tile: input, output, and the input pixel that corresponds to the first output pixel. */
struct OptixUtilDenoiserImageTile {
    OptixImage2D input;
    OptixImage2D output;
    unsigned int inputOffsetX;
    unsigned int inputOffsetY;
};

namespace optix_impl {

/** A tile along one axis, in pixels. */
struct TileSpan {
    unsigned int input;  /**< first pixel read */
    unsigned int output; /**< first pixel written */
    unsigned int count;  /**< pixels written */
};

/** Splits one axis; sets inputSize to the number of pixels each tile reads. */
inline std::vector<TileSpan> splitAxis(unsigned int size, unsigned int tile, unsigned int overlap,
                                       unsigned int& inputSize) {
    const unsigned long long wanted = tile + 2ull * overlap;
    const unsigned long long first = static_cast<unsigned long long>(tile) + overlap;
    std::vector<TileSpan> spans;
    inputSize = wanted < size ? static_cast<unsigned int>(wanted) : size;
    for (unsigned int done = 0; done < size;) {
        const unsigned long long most = done == 0 ? first : tile;
        const unsigned int left = size - done;
        TileSpan span;
        span.output = done;
        span.count = most < left ? static_cast<unsigned int>(most) : left;
        span.input = done < overlap ? 0 : done - overlap;
        if (span.input > size - inputSize)
            span.input = size - inputSize;
        spans.push_back(span);
        done += span.count;
    }
    return spans;
}

/** Part of an image that starts at pixel (x, y). */
inline OptixImage2D subImage(const OptixImage2D& image, unsigned int pixelStride, unsigned int x,
                             unsigned int y, unsigned int width, unsigned int height) {
    OptixImage2D part = image;
    part.data += static_cast<CUdeviceptr>(y) * image.rowStrideInBytes +
                 static_cast<CUdeviceptr>(x) * pixelStride;
    part.width = width;
    part.height = height;
    return part;
}

/** 1, or 2 if the output is twice as wide and high as the input and the release upscales; else
    0. */
inline unsigned int upscaling(const OptixImage2D& input, const OptixImage2D& output) {
    if (input.width == output.width && input.height == output.height)
        return 1;
#if SUNSTONE_OPTIX_API >= 70600
    if (output.width % 2 == 0 && input.width == output.width / 2 && output.height % 2 == 0 &&
        input.height == output.height / 2)
        return 2;
#endif
    return 0;
}

} // namespace optix_impl

/** Bytes from one pixel to the next: pixelStrideInBytes, or if that is 0 the size of a pixel of the
    image's format (0 for an unknown format). [3.14.2.11] */
inline unsigned int optixUtilGetPixelStride(const OptixImage2D& image) {
    if (image.pixelStrideInBytes != 0)
        return image.pixelStrideInBytes;
    switch (image.format) {
    case OPTIX_PIXEL_FORMAT_HALF2:
        return 2 * sizeof(short);
    case OPTIX_PIXEL_FORMAT_HALF3:
        return 3 * sizeof(short);
    case OPTIX_PIXEL_FORMAT_HALF4:
        return 4 * sizeof(short);
    case OPTIX_PIXEL_FORMAT_FLOAT2:
        return 2 * sizeof(float);
    case OPTIX_PIXEL_FORMAT_FLOAT3:
        return 3 * sizeof(float);
    case OPTIX_PIXEL_FORMAT_FLOAT4:
        return 4 * sizeof(float);
    case OPTIX_PIXEL_FORMAT_UCHAR3:
        return 3;
    case OPTIX_PIXEL_FORMAT_UCHAR4:
        return 4;
#if SUNSTONE_OPTIX_API >= 70600
    case OPTIX_PIXEL_FORMAT_INTERNAL_GUIDE_LAYER:
        return 0; /* only the denoiser knows: the field must be set */
#endif
    }
    return 0;
}

/** Appends the tiles that cover an image. tileWidth, tileHeight: largest output of a tile other
    than the first, in input pixels. OPTIX_ERROR_INVALID_VALUE: one of them is 0, the images are
    empty or differ in size (7.6: and the output is not twice as wide and high as the input), or a
    format is unknown. [3.14.2.10] */
inline OptixResult optixUtilDenoiserSplitImage(const OptixImage2D& input,
                                               const OptixImage2D& output,
                                               unsigned int overlapWindowSizeInPixels,
                                               unsigned int tileWidth, unsigned int tileHeight,
                                               std::vector<OptixUtilDenoiserImageTile>& tiles) {
    const unsigned int inputStride = optixUtilGetPixelStride(input);
    const unsigned int outputStride = optixUtilGetPixelStride(output);
    const unsigned int factor = optix_impl::upscaling(input, output);
    if (tileWidth == 0 || tileHeight == 0 || input.width == 0 || input.height == 0 || factor == 0 ||
        inputStride == 0 || outputStride == 0)
        return OPTIX_ERROR_INVALID_VALUE;
    unsigned int width, height;
    const std::vector<optix_impl::TileSpan> columns =
        optix_impl::splitAxis(input.width, tileWidth, overlapWindowSizeInPixels, width);
    const std::vector<optix_impl::TileSpan> rows =
        optix_impl::splitAxis(input.height, tileHeight, overlapWindowSizeInPixels, height);
    for (const optix_impl::TileSpan& row : rows) {
        for (const optix_impl::TileSpan& column : columns) {
            OptixUtilDenoiserImageTile tile;
            tile.input =
                optix_impl::subImage(input, inputStride, column.input, row.input, width, height);
            tile.output = optix_impl::subImage(output, outputStride, factor * column.output,
                                               factor * row.output, factor * column.count,
                                               factor * row.count);
            tile.inputOffsetX = column.output - column.input;
            tile.inputOffsetY = row.output - row.input;
            tiles.push_back(tile);
        }
    }
    return OPTIX_SUCCESS;
}

/** Calls optixDenoiserInvoke for one tile after the other, with the same scratch memory. The
    denoiser must be set up for tileWidth + 2 * overlap by tileHeight + 2 * overlap pixels. Guide
    layers and previous outputs whose data is 0 are ignored. In temporal models previousOutput and
    output must not share memory, because each tile reads pixels that its neighbours write.
    OPTIX_ERROR_INVALID_VALUE: guideLayer or layers is null, numLayers is 0, images differ in size;
    else the first error of optixDenoiserInvoke. [3.14.2.9] */
inline OptixResult optixUtilDenoiserInvokeTiled(
    OptixDenoiser denoiser, CUstream stream, const OptixDenoiserParams* params,
    CUdeviceptr denoiserState, size_t denoiserStateSizeInBytes,
    const OptixDenoiserGuideLayer* guideLayer, const OptixDenoiserLayer* layers,
    unsigned int numLayers, CUdeviceptr scratch, size_t scratchSizeInBytes,
    unsigned int overlapWindowSizeInPixels, unsigned int tileWidth, unsigned int tileHeight) {
    typedef std::vector<OptixUtilDenoiserImageTile> Tiles;
    if (!guideLayer || !layers || numLayers == 0)
        return OPTIX_ERROR_INVALID_VALUE;

    OptixResult result = OPTIX_SUCCESS;
    const OptixImage2D& whole = layers[0].output;
    const unsigned int factor = optix_impl::upscaling(layers[0].input, whole);
    if (factor == 0)
        return OPTIX_ERROR_INVALID_VALUE;
    /* scale: 1 for images of the input's size, factor for images of the output's size */
    const auto split = [&](const OptixImage2D& input, const OptixImage2D& output,
                           unsigned int scale, Tiles& tiles) {
        if (result != OPTIX_SUCCESS || input.data == 0)
            return;
        if (output.width != whole.width || output.height != whole.height ||
            optix_impl::upscaling(input, output) != factor / scale)
            result = OPTIX_ERROR_INVALID_VALUE;
        else
            result = optixUtilDenoiserSplitImage(input, output, scale * overlapWindowSizeInPixels,
                                                 scale * tileWidth, scale * tileHeight, tiles);
    };
    std::vector<Tiles> images(numLayers), previous(numLayers);
    Tiles albedo, normal, flow;
#if SUNSTONE_OPTIX_API >= 70600
    Tiles internal;
    if (guideLayer->outputInternalGuideLayer.data != 0)
        split(guideLayer->previousOutputInternalGuideLayer, guideLayer->outputInternalGuideLayer,
              factor, internal);
#endif
    for (unsigned int i = 0; i < numLayers; ++i) {
        split(layers[i].input, layers[i].output, 1, images[i]);
        split(layers[i].previousOutput, layers[i].output, factor, previous[i]);
        if (result == OPTIX_SUCCESS && images[i].empty())
            result = OPTIX_ERROR_INVALID_VALUE;
    }
    split(guideLayer->albedo, whole, 1, albedo);
    split(guideLayer->normal, whole, 1, normal);
    split(guideLayer->flow, whole, 1, flow);

    for (size_t t = 0; result == OPTIX_SUCCESS && t < images[0].size(); ++t) {
        std::vector<OptixDenoiserLayer> tileLayers(layers, layers + numLayers);
        for (unsigned int i = 0; i < numLayers; ++i) {
            tileLayers[i].input = images[i][t].input;
            tileLayers[i].output = images[i][t].output;
            if (!previous[i].empty())
                tileLayers[i].previousOutput = previous[i][t].input;
        }
        OptixDenoiserGuideLayer tileGuide = *guideLayer;
        if (!albedo.empty())
            tileGuide.albedo = albedo[t].input;
        if (!normal.empty())
            tileGuide.normal = normal[t].input;
        if (!flow.empty())
            tileGuide.flow = flow[t].input;
#if SUNSTONE_OPTIX_API >= 70600
        if (!internal.empty()) {
            tileGuide.previousOutputInternalGuideLayer = internal[t].input;
            tileGuide.outputInternalGuideLayer = internal[t].output;
        }
#endif
        result =
            optixDenoiserInvoke(denoiser, stream, params, denoiserState, denoiserStateSizeInBytes,
                                &tileGuide, tileLayers.data(), numLayers, images[0][t].inputOffsetX,
                                images[0][t].inputOffsetY, scratch, scratchSizeInBytes);
    }
    return result;
}

#endif
