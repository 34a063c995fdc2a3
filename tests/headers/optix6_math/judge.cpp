// SPDX-License-Identifier: Apache-2.0
#include "judge.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <stdexcept>

namespace math {
namespace {

const Real kPi = 3.14159265358979323846264338327950288L;

Type parseType(std::string text) {
    Type type;
    const bool constant = text.compare(0, 6, "const ") == 0;
    if (constant)
        text.erase(0, 6);
    if (text.back() == '&') {
        type.written = !constant;
        text.pop_back();
    }
    type.name = text;
    type.scalar = Type::kFloat;
    type.rows = type.columns = 1;
    if (text.compare(0, 14, "optix::Matrix<") == 0) {
        type.rows = text[14] - '0';
        type.columns = text[17] - '0';
        return type;
    }
    if (text == "optix::Quaternion" || text == "optix::Ray") {
        type.rows = text == "optix::Ray" ? 9 : 4;
        return type;
    }
    if (text.back() >= '1' && text.back() <= '4') {
        type.rows = text.back() - '0';
        text.pop_back();
    }
    static const std::map<std::string, Type::Scalar> scalars = {
        {"float", Type::kFloat},
        {"int", Type::kInt},
        {"uint", Type::kUint},
        {"unsigned int", Type::kUint},
        {"longlong", Type::kLongLong},
        {"long long", Type::kLongLong},
        {"ulonglong", Type::kUlongLong},
        {"unsigned long long", Type::kUlongLong},
        {"bool", Type::kBool}};
    type.scalar = scalars.at(text);
    return type;
}

Real dot(const Reals& a, const Reals& b) {
    Real sum = 0;
    for (size_t i = 0; i < a.size(); ++i)
        sum += a[i] * b[i];
    return sum;
}
Reals cross(const Reals& a, const Reals& b) {
    Reals c(3);
    for (int i = 0; i < 3; ++i)
        c[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
    return c;
}
// x * a + y * b.
Reals sum(Real x, const Reals& a, Real y, const Reals& b) {
    Reals c(a.size());
    for (size_t i = 0; i < a.size(); ++i)
        c[i] = x * a[i] + y * b[i];
    return c;
}
Reals unit(const Reals& a) {
    return sum(1 / std::sqrt(dot(a, a)), a, 0, a);
}
Reals part(const Reals& a, int from, int count) {
    return Reals(a.begin() + from, a.begin() + from + count);
}

// Applies a function to the components of vectors; scalars count for each component.
template <typename F>
Reals each(const Values& v, F f) {
    size_t size = 1;
    for (const Reals& r : v)
        size = std::max(size, r.size());
    Reals result(size);
    for (size_t i = 0; i < size; ++i) {
        Reals components;
        for (const Reals& r : v)
            components.push_back(r.size() == 1 ? r[0] : r[i]);
        result[i] = f(components);
    }
    return result;
}

Real arithmetic(char op, const Reals& v) {
    switch (op) {
    case '+':
        return v[0] + v[1];
    case '-':
        return v.size() == 1 ? -v[0] : v[0] - v[1];
    case '*':
        return v[0] * v[1];
    default:
        return v[0] / v[1];
    }
}

// Sums over the inner index. A Quaternion on the left rotates by q (0, v) q^-1.
Reals product(const Type& a, const Reals& x, const Type& b, const Reals& y) {
    if (a.name == "optix::Quaternion") {
        const Reals axis = part(x, 0, 3), v = part(y, 0, 3);
        const Reals imaginary = sum(x[3], v, 1, cross(axis, v)); // q (0, v) = (real, imaginary)
        const Real real = -dot(axis, v);
        Reals turned = sum(x[3], imaginary, -real, axis);
        turned = sum(1, turned, -1, cross(imaginary, axis));
        if (y.size() == 4)
            turned.push_back(y[3]);
        return turned;
    }
    const bool row = a.columns == 1; // a vector on the left is a row
    const int rows = row ? 1 : a.rows, inner = row ? a.rows : a.columns, columns = b.columns;
    Reals result(rows * columns);
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j)
            for (int k = 0; k < inner; ++k)
                result[i * columns + j] += x[i * inner + k] * y[k * columns + j];
    return result;
}

bool isProduct(const Case& c) {
    if (c.name[8] != '*' || c.parameters.size() != 2)
        return false;
    const auto linear = [](const Type& t) { return t.name.compare(0, 7, "optix::") == 0; };
    return (linear(c.parameters[0]) && c.parameters[1].size() > 1) ||
           (linear(c.parameters[1]) && c.parameters[0].size() > 1);
}

Values operators(const Case& c, const Values& v) {
    const std::string op = c.name.substr(8);
    if (op == "==" || op == "!=")
        return {{Real((v[0] == v[1]) == (op == "=="))}};
    const Reals result = isProduct(c)
                             ? product(c.parameters[0], v[0], c.parameters[1], v[1])
                             : each(v, [&](const Reals& r) { return arithmetic(op[0], r); });
    return Values(c.results.size(), result);
}

// Vectors from parts, from one value, from the first components of a wider vector; else padded.
Values make(const Case& c, const Values& v) {
    Reals all;
    for (const Reals& r : v)
        all.insert(all.end(), r.begin(), r.end());
    all.resize(c.results[0].rows, v.size() == 1 && v[0].size() == 1 ? all[0] : 0);
    if (!c.results[0].isFloat())
        for (Real& r : all)
            r = std::trunc(r);
    return {all};
}

Reals mix(const Reals& a, const Reals& b, Real t) {
    return sum(1 - t, a, t, b);
}

Real smooth(Real low, Real high, Real x) {
    const Real t = std::min(Real(1), std::max(Real(0), (x - low) / (high - low)));
    return 3 * t * t - 2 * t * t * t;
}

// Snell's law with the part of i along the surface.
Values refraction(const Values& v) {
    const Real along = dot(v[1], v[2]);
    const Reals normal = sum(along > 0 ? -1 : 1, v[2], 0, v[2]); // against i
    const Reals surface = sum(1, v[1], -dot(v[1], normal), normal);
    const Real eta = along > 0 ? v[3][0] : 1 / v[3][0];
    const Real sineSquared = eta * eta * dot(surface, surface);
    if (sineSquared > 1)
        return {{0}, {0, 0, 0}};
    return {{1}, unit(sum(eta, surface, -std::sqrt(1 - sineSquared), normal))};
}

// Areas of the triangles at the point in the plane.
Values intersection(const Values& v) {
    const Reals origin = part(v[0], 0, 3), direction = part(v[0], 3, 3);
    const Reals a = sum(1, v[2], -1, v[1]), b = sum(1, v[3], -1, v[1]), n = cross(a, b);
    const Real t = dot(n, sum(1, v[1], -1, origin)) / dot(n, direction);
    const Reals p = sum(1, sum(1, origin, t, direction), -1, v[1]);
    const Real beta = dot(cross(p, b), n) / dot(n, n), gamma = dot(cross(a, p), n) / dot(n, n);
    const bool hit = t > v[0][7] && t < v[0][8] && beta >= 0 && gamma >= 0 && beta + gamma <= 1;
    return {{Real(hit)}, n, {t}, {beta}, {gamma}};
}

Reals disk(const Reals& sample) {
    const Real x = 2 * sample[0] - 1, y = 2 * sample[1] - 1;
    const Real radius = std::max(std::fabs(x), std::fabs(y));
    if (radius == 0)
        return {0, 0};
    // The distance along the square of this radius, from (radius, 0), divided by the radius.
    const Real way =
        std::fabs(x) > std::fabs(y) ? (x > 0 ? y / x : 4 + y / x) : (y > 0 ? 2 - x / y : 6 - x / y);
    return {radius * std::cos(way * kPi / 4), radius * std::sin(way * kPi / 4)};
}

Reals polar(const Reals& v) {
    const Real azimuth = std::atan2(v[1], v[0]), length = std::sqrt(dot(v, v));
    return {azimuth < 0 ? azimuth + 2 * kPi : azimuth, std::asin(v[2] / length), length};
}

Real schlick(Real cosine, Real exponent, Real low, Real high) {
    return low + (high - low) * std::pow(1 - cosine, exponent);
}

Real bits(Real f) {
    const float value = float(f);
    int i;
    std::copy_n(reinterpret_cast<const char*>(&value), 4, reinterpret_cast<char*>(&i));
    return i;
}
Real fromBits(Real i) {
    const int value = int(i);
    float f;
    std::copy_n(reinterpret_cast<const char*>(&value), 4, reinterpret_cast<char*>(&f));
    return f;
}

using Judge = std::function<Values(const Values&)>;

Values chosen(const Values& v, bool least) {
    const auto better = [&](Real a, Real b) { return least ? a < b : a > b; };
    if (v.size() == 1)
        return {{*std::min_element(v[0].begin(), v[0].end(), better)}};
    return {each(v, [&](const Reals& r) { return better(r[1], r[0]) ? r[1] : r[0]; })};
}
Values least(const Values& v) {
    return chosen(v, true);
}
Values most(const Values& v) {
    return chosen(v, false);
}

Values byIndex(const Values& v) {
    const size_t i = std::min(size_t(v[1][0]), v[0].size() - 1);
    if (v.size() == 2)
        return {{v[0][i]}};
    Reals changed = v[0];
    changed[i] = v[2][0];
    return {changed};
}

const std::map<std::string, Judge>& vectorJudges() {
    static const std::map<std::string, Judge> judges = {
        {"min", least},
        {"max", most},
        {"fminf", least},
        {"fmaxf", most},
        {"getByIndex", byIndex},
        {"setByIndex", byIndex},
        {"clamp",
         [](const Values& v) -> Values {
             return {each(v, [](const Reals& r) { return std::max(r[1], std::min(r[0], r[2])); })};
         }},
        {"floor",
         [](const Values& v) -> Values {
             return {each(v, [](const Reals& r) { return std::floor(r[0]); })};
         }},
        {"expf",
         [](const Values& v) -> Values {
             return {each(v, [](const Reals& r) { return std::exp(r[0]); })};
         }},
        {"lerp", [](const Values& v) -> Values { return {mix(v[0], v[1], v[2][0])}; }},
        {"nlerp", [](const Values& v) -> Values { return {unit(mix(v[0], v[1], v[2][0]))}; }},
        {"bilerp",
         [](const Values& v) -> Values {
             return {mix(mix(v[0], v[1], v[4][0]), mix(v[2], v[3], v[4][0]), v[5][0])};
         }},
        {"dot", [](const Values& v) -> Values { return {{dot(v[0], v[1])}}; }},
        {"cross", [](const Values& v) -> Values { return {cross(v[0], v[1])}; }},
        {"length", [](const Values& v) -> Values { return {{std::sqrt(dot(v[0], v[0]))}}; }},
        {"normalize", [](const Values& v) -> Values { return {unit(v[0])}; }},
        {"reflect",
         [](const Values& v) -> Values { return {sum(1, v[0], -2 * dot(v[0], v[1]), v[1])}; }},
        {"faceforward",
         [](const Values& v) -> Values {
             return {sum(dot(v[1], v[2]) > 0 ? 1 : -1, v[0], 0, v[0])};
         }},
        {"make_matrix3x3", [](const Values& v) -> Values {
             return {{v[0][0], v[0][1], v[0][2], v[0][4], v[0][5], v[0][6], v[0][8], v[0][9],
                      v[0][10]}};
         }}};
    return judges;
}

const std::map<std::string, Judge>& otherJudges() {
    static const std::map<std::string, Judge> judges = {
        {"copysignf",
         [](const Values& v) -> Values { return {{std::copysign(v[0][0], v[1][0])}}; }},
        {"float_as_int", [](const Values& v) -> Values { return {{bits(v[0][0])}}; }},
        {"int_as_float", [](const Values& v) -> Values { return {{fromBits(v[0][0])}}; }},
        {"smoothstep",
         [](const Values& v) -> Values { return {{smooth(v[0][0], v[1][0], v[2][0])}}; }},
        {"temperature",
         [](const Values& v) -> Values {
             const Real t = v[0][0];
             return {{smooth(0.5L, 0.75L, t),
                      t < 0.5L ? smooth(0, 0.5L, t) : 1 - smooth(0.75L, 1, t),
                      1 - smooth(0.25L, 0.5L, t)}};
         }},
        {"intersect_triangle", intersection},
        {"intersect_triangle_branchless", intersection},
        {"intersect_triangle_earlyexit", intersection},
        {"refract", refraction},
        {"fresnel_schlick",
         [](const Values& v) -> Values {
             return {each(v, [](const Reals& r) { return schlick(r[0], r[1], r[2], r[3]); })};
         }},
        {"luminance",
         [](const Values& v) -> Values { return {{dot(v[0], {0.30L, 0.59L, 0.11L})}}; }},
        {"luminanceCIE",
         [](const Values& v) -> Values { return {{dot(v[0], {0.2126L, 0.7152L, 0.0722L})}}; }},
        {"cosine_sample_hemisphere",
         [](const Values& v) -> Values {
             const Real r = std::sqrt(v[0][0]), phi = 2 * kPi * v[1][0];
             return {{r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - v[0][0])}};
         }},
        {"square_to_disk", [](const Values& v) -> Values { return {disk(v[0])}; }},
        {"cart_to_pol", [](const Values& v) -> Values { return {polar(v[0])}; }}};
    return judges;
}

} // namespace

Case::Case(const char* fullName, const char* text) : name(fullName), signature(text) {
    const size_t angle = name.find('<', 8); // operators of streams have no cases
    if (angle != std::string::npos)
        name.resize(angle);
    const size_t open = signature.find('(');
    if (signature.compare(0, open, "void") != 0)
        results.push_back(parseType(signature.substr(0, open)));
    int depth = 0;
    std::string part;
    for (size_t i = open + 1; i < signature.size(); ++i) {
        const char letter = signature[i];
        depth += letter == '<' ? 1 : letter == '>' ? -1 : 0;
        if ((letter == ',' && depth == 0) || letter == ')') {
            parameters.push_back(parseType(part));
            part.clear();
        } else if (letter != ' ' || !part.empty()) {
            part += letter;
        }
    }
    for (const Type& type : parameters)
        if (type.written)
            results.push_back(type);
}

Values expected(const Case& c, const Values& arguments) {
    Values result;
    if (c.name.compare(0, 8, "operator") == 0)
        result = operators(c, arguments);
    else if (c.name.compare(0, 5, "make_") == 0 && c.name != "make_matrix3x3")
        result = make(c, arguments);
    else if (vectorJudges().count(c.name))
        result = vectorJudges().at(c.name)(arguments);
    else if (otherJudges().count(c.name))
        result = otherJudges().at(c.name)(arguments);
    else
        throw std::out_of_range("no meaning of " + c.name);
    for (size_t i = 0; i < result.size(); ++i)
        for (Real& r : result[i]) {
            const Type::Scalar scalar = c.results.at(i).scalar;
            if (scalar != Type::kFloat && scalar != Type::kBool)
                r = std::trunc(r);
            if (scalar == Type::kUint || scalar == Type::kUlongLong) // differences wrap
                r += r < 0 ? std::ldexp(Real(1), scalar == Type::kUint ? 32 : 64) : 0;
        }
    return result;
}

} // namespace math
