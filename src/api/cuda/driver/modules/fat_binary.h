// SPDX-License-Identifier: Apache-2.0
// Images given to cuModuleLoad*: PTX text, or a fat binary (wrapper or container) that holds PTX,
// compressed or not. The bytes are untrusted; memory is probed before it is read.
//
// Layout of a fat binary. Wrapper: u32 magic 0x466243B1, u32 version, pointer to the container.
// Container: u32 magic 0xBA55ED50, u16 version, u16 header size, u64 size of the entries. Entry:
// see fat_binary.cpp. Further containers may follow (linked objects).
//
// A linked image is the result of cuLinkComplete: a header, then each PTX text with its NUL.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sunstone::api::cuda {

// The PTX texts of an image: one, or those of a linked image. Throws Failure:
// CUDA_ERROR_INVALID_VALUE for null, CUDA_ERROR_INVALID_IMAGE for a damaged image,
// CUDA_ERROR_NO_BINARY_FOR_GPU for machine code without PTX.
std::vector<std::string> ptxOfImage(const void* image);
// The same for an image of known size.
std::vector<std::string> ptxOfBytes(const void* image, size_t size);

// The same for a file.
std::vector<std::string> ptxOfFile(const char* path);

std::string makeLinkedImage(const std::vector<std::string>& texts);

} // namespace sunstone::api::cuda
