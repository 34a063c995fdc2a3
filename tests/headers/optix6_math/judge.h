// SPDX-License-Identifier: Apache-2.0
// Reference results of the classic API's mathematical functions, in long double, which holds every
// 64-bit integer. Written from the manual, independently of the headers.
#pragma once

#include <string>
#include <vector>

namespace math {

using Real = long double;
using Reals = std::vector<Real>;

struct Type {
    enum Scalar { kFloat, kInt, kUint, kLongLong, kUlongLong, kBool } scalar;
    std::string name;     // float3, optix::Matrix<2, 3>, ...
    int rows, columns;    // vectors are columns; those of Ray and Quaternion are one column
    bool written = false; // a reference to a variable

    int size() const { return rows * columns; }
    bool isFloat() const { return scalar == kFloat; }
    bool isUnsigned() const { return scalar == kUint || scalar == kUlongLong; }
};

struct Case {
    Case(const char* name, const char* signature);

    std::string name; // without template arguments
    std::string signature;
    std::vector<Type> parameters;
    std::vector<Type> results; // the result and the parameters that are written
};

// Arguments or results, each a sequence of components.
using Values = std::vector<Reals>;
Values expected(const Case& c, const Values& arguments);

} // namespace math
