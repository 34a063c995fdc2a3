// SPDX-License-Identifier: Apache-2.0
// Differences between nvcc's dialect and clang's, bridged on text.
#pragma once

#include <string>
#include <string_view>

namespace sunstone::nvrtc {

// clang's message for a register's name behind a single % in assembly with operands:
//     asm("mov.u32 %0, %laneid;" : "=r"(lane));
constexpr char kInvalidPercent[] = "invalid % escape in inline assembly string";

// Preprocessed source in which such names have two %, as clang requires. nvcc passes them on.
std::string doublePercents(std::string_view source);

// The same for a file.
void doublePercentsOfFile(const std::string& path);

// PTX of a whole program, in which nvcc defines the variables that the source only declares:
//     extern "C" __constant__ float table[4];
// Arrays without a size stay declarations.
std::string defineVariables(std::string ptx);

// PTX of a file with relocatable device code. Host code may name a static variable below the first
// kernel that uses it. clang then defines the variable with the file's id in its name, but the
// kernel refers to an external variable of the plain name. Such references get the name of the
// definition.
std::string referToStaticVariables(std::string ptx);

} // namespace sunstone::nvrtc
