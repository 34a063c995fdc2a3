// SPDX-License-Identifier: Apache-2.0
// The rows of symbols.tsv that no compiler checks: functions that the libraries export, names that
// they take as text, and names that the headers leave out.
#include <optix.h>

#include <gtest/gtest.h>

#include <dlfcn.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

namespace {

struct Row {
    std::string kind, symbol, detail;
};

const std::vector<Row>& rows() {
    static const auto* const all = [] {
        auto* read = new std::vector<Row>;
        std::ifstream table(SUNSTONE_TABLE);
        for (std::string line; std::getline(table, line);) {
            const size_t first = line.find('\t'), second = line.find('\t', first + 1);
            read->push_back({line.substr(0, first), line.substr(first + 1, second - first - 1),
                             line.substr(second + 1)});
        }
        return read;
    }();
    return *all;
}

std::string contentOf(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
}

// Expects that the library exports all names of the kind; returns their number.
size_t expectExported(const std::string& kind, const char* path, bool onlyMarked = false) {
    void* library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    EXPECT_NE(library, nullptr) << dlerror();
    if (!library)
        return 0;
    size_t count = 0;
    for (const Row& row : rows())
        if (row.kind == kind && (!onlyMarked || row.detail == "exported")) {
            ++count;
            EXPECT_NE(dlsym(library, row.symbol.c_str()), nullptr) << row.symbol;
        }
    return count;
}

TEST(ClassicSymbols, FunctionsAreExported) {
    EXPECT_EQ(expectExported("function", SUNSTONE_OPTIX6), 424u);
    EXPECT_EQ(expectExported("prime function", SUNSTONE_PRIME), 35u);
    EXPECT_EQ(expectExported("rtu function", SUNSTONE_OPTIXU, true), 5u);
}

// Programs of releases before 6.0 link the first names, others the full number of their release.
TEST(ClassicSymbols, LibrariesHaveTheNamesOfReleases) {
    for (const auto& [library, names] :
         {std::pair(SUNSTONE_OPTIX6,
                    std::vector<std::string>{"liboptix.so.1", "liboptix.so.5.0.0",
                                             "liboptix.so.5.0.1", "liboptix.so.5.1.0",
                                             "liboptix.so.5.1.1", "liboptix.so.6.0.0",
                                             "liboptix.so.6.5.0"}),
          std::pair(SUNSTONE_OPTIXU,
                    std::vector<std::string>{"liboptixu.so.1", "liboptixu.so.5.1.0",
                                             "liboptixu.so.5.1.1", "liboptixu.so.6.0.0",
                                             "liboptixu.so.6.5.0"})})
        for (const std::string& name : names) {
            const auto alias = std::filesystem::path(library).parent_path() / name;
            EXPECT_TRUE(std::filesystem::exists(alias) &&
                        std::filesystem::equivalent(alias, library))
                << name;
        }
}

TEST(ClassicSymbols, BuildersAndPropertiesAreAccepted) {
    RTcontext context = nullptr;
    RTacceleration acceleration = nullptr;
    ASSERT_EQ(rtContextCreate(&context), RT_SUCCESS);
    ASSERT_EQ(rtAccelerationCreate(context, &acceleration), RT_SUCCESS);
    EXPECT_NE(rtAccelerationSetBuilder(acceleration, "NoSuchBuilder"), RT_SUCCESS);
    for (const Row& row : rows()) {
        const char* name = row.symbol.c_str();
        if (row.kind == "builder")
            EXPECT_EQ(rtAccelerationSetBuilder(acceleration, name), RT_SUCCESS) << name;
        if (row.kind != "acceleration")
            continue;
        const char* value = nullptr;
        EXPECT_EQ(rtAccelerationSetProperty(acceleration, name, "1"), RT_SUCCESS) << name;
        EXPECT_EQ(rtAccelerationGetProperty(acceleration, name, &value), RT_SUCCESS) << name;
        EXPECT_STREQ(value, "1") << name;
    }
    rtContextDestroy(context);
}

TEST(ClassicSymbols, NamesInTextsAreKnownToTheLibraries) {
    const std::string libraries = contentOf(SUNSTONE_OPTIX6) + contentOf(SUNSTONE_LIBRARY);
    for (const Row& row : rows())
        if (row.kind == "text")
            EXPECT_NE(libraries.find(row.symbol), std::string::npos) << row.symbol;
}

// A name that the headers get is a row of another kind.
TEST(ClassicSymbols, AbsentNamesAreAbsent) {
    std::set<std::string> words;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(SUNSTONE_HEADERS)) {
        if (!entry.is_regular_file())
            continue;
        std::string word;
        for (const char c : contentOf(entry.path()) + " ") {
            if (std::isalnum(static_cast<unsigned char>(c)) || c == '_') {
                word += c;
                continue;
            }
            words.insert(word);
            word.clear();
        }
    }
    EXPECT_TRUE(words.contains("rtContextCreate"));
    for (const Row& row : rows())
        if (row.kind == "absent") {
            EXPECT_FALSE(row.detail.empty()) << row.symbol;
            if (row.detail != "a name of another interface") // which comments may have
                EXPECT_FALSE(words.contains(row.symbol)) << row.symbol;
        }
}

} // namespace
