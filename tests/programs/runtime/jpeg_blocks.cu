// SPDX-License-Identifier: Apache-2.0
// A picture codec: transform of blocks of 8 by 8 with the separable cosine transform in shared
// memory, quantisation with tables in constant structs, zigzag order, run lengths written at places
// that a scan by warps finds; then back. The stream must be that of the host, the picture close.
#include "device.h"

#include <cmath>
#include <cstdint>
#include <vector>

struct Tables {
    float cosine[8][8];
    unsigned char order[64];
    unsigned short quant[64];
};
__constant__ Tables tables;

struct Token {
    unsigned char run;
    signed char pad;
    short level;
};

__device__ __forceinline__ float transformed(const float (*in)[9], int row, int column,
                                             bool inverse) {
    float sum = 0;
#pragma unroll
    for (int k = 0; k < 8; ++k)
        sum += in[row][k] * (inverse ? tables.cosine[k][column] : tables.cosine[column][k]);
    return sum;
}

__global__ void encode(const uint8_t* image, int pitch, short* levels) {
    __shared__ float a[8][9], b[8][9];
    const int x = threadIdx.x, y = threadIdx.y, block = blockIdx.y * gridDim.x + blockIdx.x;
    a[y][x] = float(image[(blockIdx.y * 8 + y) * pitch + blockIdx.x * 8 + x]) - 128.0f;
    __syncthreads();
    b[x][y] = transformed(a, y, x, false); // transposed
    __syncthreads();
    const float value = transformed(b, y, x, false); // of column y, row x
    const int position = x * 8 + y;
    levels[block * 64 + position] = short(rintf(value / tables.quant[position]));
}

// A warp for each block: how many tokens it has, then the tokens.
__device__ unsigned tokensOf(const short* levels, Token* out) {
    const unsigned lane = threadIdx.x & 31;
    unsigned written = 0, zeros = 0;
    for (int half = 0; half < 2; ++half) {
        const short level = levels[tables.order[half * 32 + lane]];
        const unsigned set = __ballot_sync(~0u, level != 0), below = set & ((1u << lane) - 1);
        if (level && out) {
            const unsigned run = below ? lane - (32 - __clz(below)) : zeros + lane;
            out[written + __popc(below)] = {(unsigned char)run, 0, level};
        }
        written += __popc(set);
        zeros = set ? __clz(set) : zeros + 32;
    }
    return written;
}

__global__ void countTokens(const short* levels, unsigned* counts, int blocks) {
    const int block = (blockIdx.x * blockDim.x + threadIdx.x) / 32;
    if (block >= blocks)
        return;
    const unsigned count = tokensOf(levels + block * 64, nullptr);
    if (threadIdx.x % 32 == 0)
        counts[block] = count;
}

__global__ void scan(unsigned* counts, int n) { // exclusive, one block
    __shared__ unsigned sums[32], carry;
    if (threadIdx.x == 0)
        carry = 0;
    __syncthreads();
    const unsigned lane = threadIdx.x & 31, warp = threadIdx.x / 32;
    for (int base = 0; base < n; base += blockDim.x) {
        const int i = base + threadIdx.x;
        const unsigned own = i < n ? counts[i] : 0;
        unsigned sum = own;
        for (unsigned step = 1; step < 32; step *= 2) {
            const unsigned other = __shfl_up_sync(~0u, sum, step);
            sum += lane >= step ? other : 0;
        }
        if (lane == 31)
            sums[warp] = sum;
        __syncthreads();
        unsigned before = carry;
        for (unsigned w = 0; w < warp; ++w)
            before += sums[w];
        if (i < n)
            counts[i] = before + sum - own;
        __syncthreads();
        if (threadIdx.x == blockDim.x - 1)
            carry = before + sum;
        __syncthreads();
    }
    if (threadIdx.x == 0)
        counts[n] = carry;
}

__global__ void writeTokens(const short* levels, const unsigned* places, Token* out, int blocks) {
    const int block = (blockIdx.x * blockDim.x + threadIdx.x) / 32;
    if (block < blocks)
        tokensOf(levels + block * 64, out + places[block]);
}

__global__ void decode(const Token* tokens, const unsigned* places, uint8_t* image, int pitch) {
    __shared__ float a[8][9], b[8][9];
    const int x = threadIdx.x, y = threadIdx.y, block = blockIdx.y * gridDim.x + blockIdx.x;
    a[y][x] = 0;
    __syncthreads();
    if (x == 0 && y == 0) {
        unsigned position = 0;
        for (unsigned t = places[block]; t < places[block + 1]; ++t) {
            position += tokens[t].run;
            const int at = tables.order[position++];
            a[at / 8][at % 8] = float(tokens[t].level) * tables.quant[at];
        }
    }
    __syncthreads();
    b[x][y] = transformed(a, y, x, true);
    __syncthreads();
    const float value = transformed(b, y, x, true);
    const int pixel = __float2int_rn(value) + 128;
    image[(blockIdx.y * 8 + x) * pitch + blockIdx.x * 8 + y] = uint8_t(pixel < 0     ? 0
                                                                       : pixel > 255 ? 255
                                                                                     : pixel);
}

static Tables makeTables() {
    Tables t;
    for (int k = 0; k < 8; ++k)
        for (int i = 0; i < 8; ++i)
            t.cosine[k][i] = float((k ? 0.5 : std::sqrt(0.125)) *
                                   std::cos((2 * i + 1) * k * 3.14159265358979 / 16));
    int x = 0, y = 0;
    for (int i = 0; i < 64; ++i) {
        t.order[i] = (unsigned char)(y * 8 + x);
        const bool up = (x + y) % 2 == 0;
        if (up ? x == 7 : y == 7)
            (up ? y : x) += 1;
        else if (up ? y == 0 : x == 0)
            (up ? x : y) += 1;
        else {
            x += up ? 1 : -1;
            y += up ? -1 : 1;
        }
    }
    for (int i = 0; i < 64; ++i)
        t.quant[i] = (unsigned short)(3 + 2 * (i / 8 + i % 8));
    return t;
}

int main() {
    constexpr int kWide = 136, kHigh = 72, kBlocks = kWide / 8 * (kHigh / 8);
    std::vector<uint8_t> image(kWide * kHigh), back(image.size());
    for (int y = 0; y < kHigh; ++y)
        for (int x = 0; x < kWide; ++x)
            image[y * kWide + x] = uint8_t(128 + 60 * std::sin(x * 0.11) +
                                           50 * std::cos(y * 0.17 + x * 0.02) + (x * y % 11));
    const Tables t = makeTables();
    CUDA(cudaMemcpyToSymbol(tables, &t, sizeof t));
    uint8_t *in, *out;
    size_t pitch;
    short* levels;
    unsigned* places;
    Token* tokens;
    CUDA(cudaMallocPitch(&in, &pitch, kWide, kHigh));
    CUDA(cudaMallocPitch(&out, &pitch, kWide, kHigh));
    CUDA(cudaMalloc(&levels, kBlocks * 64 * sizeof(short)));
    CUDA(cudaMalloc(&places, (kBlocks + 1) * sizeof(unsigned)));
    CUDA(cudaMalloc(&tokens, kBlocks * 64 * sizeof(Token)));
    CUDA(cudaMemcpy2D(in, pitch, image.data(), kWide, kWide, kHigh, cudaMemcpyHostToDevice));
    const dim3 grid(kWide / 8, kHigh / 8), block(8, 8);
    encode<<<grid, block>>>(in, int(pitch), levels);
    countTokens<<<(kBlocks + 3) / 4, 128>>>(levels, places, kBlocks);
    scan<<<1, 64>>>(places, kBlocks);
    writeTokens<<<(kBlocks + 3) / 4, 128>>>(levels, places, tokens, kBlocks);
    decode<<<grid, block>>>(tokens, places, out, int(pitch));
    CUDA(cudaMemcpy2D(back.data(), kWide, out, pitch, kWide, kHigh, cudaMemcpyDeviceToHost));

    std::vector<short> seen(kBlocks * 64);
    std::vector<unsigned> seenPlaces(kBlocks + 1);
    std::vector<Token> seenTokens(kBlocks * 64);
    CUDA(cudaMemcpy(seen.data(), levels, seen.size() * 2, cudaMemcpyDeviceToHost));
    CUDA(cudaMemcpy(seenPlaces.data(), places, seenPlaces.size() * 4, cudaMemcpyDeviceToHost));
    CUDA(cudaMemcpy(seenTokens.data(), tokens, seenTokens.size() * 4, cudaMemcpyDeviceToHost));
    int wrong = 0, offByOne = 0;
    unsigned place = 0;
    double error = 0;
    for (int b = 0; b < kBlocks; ++b) {
        const uint8_t* corner = &image[b / (kWide / 8) * 8 * kWide + b % (kWide / 8) * 8];
        for (int v = 0; v < 8; ++v)
            for (int u = 0; u < 8; ++u) {
                double sum = 0;
                for (int y = 0; y < 8; ++y)
                    for (int x = 0; x < 8; ++x)
                        sum += (corner[y * kWide + x] - 128.0) * t.cosine[u][x] * t.cosine[v][y];
                const int level = int(std::nearbyint(sum / t.quant[v * 8 + u]));
                const int difference = std::abs(level - seen[b * 64 + v * 8 + u]);
                offByOne += difference == 1; // of sums that lie half-way
                wrong += difference > 1;
            }
        wrong += seenPlaces[b] != place;
        unsigned run = 0;
        for (int i = 0; i < 64; ++i) {
            const short level = seen[b * 64 + t.order[i]];
            if (level == 0) {
                ++run;
                continue;
            }
            const Token& token = seenTokens[place++];
            wrong += token.run != run || token.level != level;
            run = 0;
        }
    }
    wrong += seenPlaces[kBlocks] != place;
    for (size_t i = 0; i < image.size(); ++i)
        error += std::abs(image[i] - back[i]) / double(image.size());
    std::printf("%d wrong, %d off by one, %u tokens, error %.2f\n", wrong, offByOne, place, error);
    return finish(wrong == 0 && offByOne < 20 && error < 4);
}
