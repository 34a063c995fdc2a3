// SPDX-License-Identifier: Apache-2.0
// Runs a program and compares its output with a recording of a GPU, number by number:
// compare_numbers PROGRAM EXPECTED. Numbers may differ by the filter's precision: 0.005 below 1,
// else 0.65 % of the number, which is about two weights of 1/256. All other text must be equal.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

static bool isNumber(const std::string& text, double& value) {
    char* end = nullptr;
    value = std::strtod(text.c_str(), &end);
    return end != text.c_str() && *end == 0;
}

static bool same(const std::string& a, const std::string& b) {
    double x = 0, y = 0;
    if (a == b)
        return true;
    // Hexadecimal numbers are compared as text.
    return isNumber(a, x) && isNumber(b, y) &&
           std::fabs(x - y) <= std::fmax(0.005, 0.0065 * std::fabs(y));
}

static std::string spaced(std::string line) {
    for (char& c : line)
        if (c == ',')
            c = ' ';
    return line;
}

int main(int argc, char** argv) {
    if (argc != 3)
        return 2;
    std::FILE* program = popen(argv[1], "r");
    if (!program)
        return 2;
    std::string output;
    for (int c = 0; (c = std::fgetc(program)) != EOF;)
        output += char(c);
    if (pclose(program) != 0) {
        std::printf("%s failed\n%s", argv[1], output.c_str());
        return 1;
    }
    std::istringstream got(output);
    std::ifstream want(argv[2]);
    std::string a, b;
    int bad = 0, lines = 0;
    for (; std::getline(want, b); ++lines) {
        if (!std::getline(got, a))
            a.clear();
        std::istringstream left(spaced(a)), right(spaced(b));
        std::string x, y;
        for (int word = 0; right >> y; ++word) {
            if (!(left >> x))
                x = "nothing";
            if (!same(x, y) && ++bad < 40)
                std::printf("line %d (%.30s) word %d: %s, recorded %s\n", lines + 1, b.c_str(),
                            word, x.c_str(), y.c_str());
        }
        if (left >> x)
            std::printf("line %d: more than recorded\n", lines + 1), ++bad;
    }
    if (lines == 0 || std::getline(got, a))
        ++bad;
    std::printf("%d lines, %d differences\n", lines, bad);
    return bad ? 1 : 0;
}
