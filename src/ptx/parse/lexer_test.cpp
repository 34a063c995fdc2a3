// SPDX-License-Identifier: Apache-2.0
// Tokens: kinds, values, places, faults.
#include "ptx/parse/lexer.h"
#include "ptx/test_support.h"

#include <bit>
#include <vector>

namespace sunstone::ptx::testing {
namespace {

std::vector<Token> lex(std::string_view text, Diagnostics& diagnostics) {
    Lexer lexer(text, diagnostics);
    std::vector<Token> tokens;
    for (Token token = lexer.next(); token.kind != TokenKind::kEnd; token = lexer.next())
        tokens.push_back(token);
    return tokens;
}

std::vector<Token> mustLex(std::string_view text) {
    Diagnostics diagnostics;
    auto tokens = lex(text, diagnostics);
    EXPECT_FALSE(diagnostics.failed()) << diagnostics.format();
    return tokens;
}

std::string lexError(std::string_view text) {
    Diagnostics diagnostics;
    lex(text, diagnostics);
    return diagnostics.format();
}

TEST(Lexer, SplitsOpcodesAtDots) {
    const auto tokens = mustLex("ld.global.L2::128B.v4.u32 {%r1,_},[%rd4+-16];");
    std::vector<std::string> texts;
    for (const Token& token : tokens)
        texts.emplace_back(token.text);
    EXPECT_EQ(texts,
              (std::vector<std::string>{"ld", "global", "L2::128B", "v4", "u32", "{", "%r1", ",",
                                        "_", "}", ",", "[", "%rd4", "+", "-", "16", "]", ";"}));
    EXPECT_EQ(tokens[1].kind, TokenKind::kDotWord);
    EXPECT_FALSE(tokens[1].spaceBefore);
    EXPECT_TRUE(tokens[5].spaceBefore);
}

TEST(Lexer, ColonsOfLabelsAreNotPartOfWords) {
    const auto tokens = mustLex("$L__BB0_1: .callprototype a:b");
    ASSERT_EQ(tokens.size(), 6u);
    EXPECT_EQ(tokens[0].text, "$L__BB0_1");
    EXPECT_TRUE(tokens[1].is(':'));
    EXPECT_EQ(tokens[2].text, "callprototype");
}

TEST(Lexer, Numbers) {
    const auto tokens =
        mustLex("0 42 0x1F 0XfU 017 0b101 42U 18446744073709551615 0f3F800000 0d3FF0000000000000 "
                "1.5 2. 1e3 1.5E-3");
    const uint64_t bits[] = {0, 42, 31, 15, 15, 5, 42, ~0ull, 0x3F800000, 0x3FF0000000000000};
    for (size_t i = 0; i < std::size(bits); ++i)
        EXPECT_EQ(tokens[i].bits, bits[i]) << tokens[i].text;
    EXPECT_EQ(tokens[7].kind, TokenKind::kInteger);
    EXPECT_EQ(tokens[8].kind, TokenKind::kFloat32);
    EXPECT_EQ(tokens[9].kind, TokenKind::kFloat64);
    const double values[] = {1.5, 2.0, 1000.0, 0.0015};
    for (size_t i = 0; i < std::size(values); ++i) {
        EXPECT_EQ(tokens[10 + i].kind, TokenKind::kFloat64);
        EXPECT_EQ(std::bit_cast<double>(tokens[10 + i].bits), values[i]);
    }
}

TEST(Lexer, MalformedNumbersNameTheirPlace) {
    EXPECT_EQ(lexError("\n  12abc"), "error: line 2:3: malformed number '12abc'\n");
    EXPECT_EQ(lexError("0x"), "error: line 1:1: malformed number '0x'\n");
    EXPECT_EQ(lexError("09"), "error: line 1:1: malformed number '09'\n");
    EXPECT_EQ(lexError("0b2"), "error: line 1:1: malformed number '0b2'\n");
    EXPECT_EQ(lexError("18446744073709551616"),
              "error: line 1:1: number '18446744073709551616' does not fit in 64 bits\n");
    EXPECT_EQ(lexError("0f3F8"), "error: line 1:1: malformed number '0f3F8': '0f' needs exactly 8 "
                                 "hexadecimal digits\n");
    EXPECT_EQ(lexError("0d3F800000"), "error: line 1:1: malformed number '0d3F800000': '0d' needs "
                                      "exactly 16 hexadecimal digits\n");
    EXPECT_EQ(lexError("1e999"), "error: line 1:1: number '1e999' is out of the range of .f64\n");
}

TEST(Lexer, CommentsAndLinesCountForPlaces) {
    const auto tokens = mustLex("// one\n/* two\n three */ a\r\n\tb /**/c // end");
    ASSERT_EQ(tokens.size(), 3u);
    EXPECT_EQ(tokens[0].location.line, 3u);
    EXPECT_EQ(tokens[0].location.column, 11u);
    EXPECT_EQ(tokens[1].location.line, 4u);
    EXPECT_EQ(tokens[1].location.column, 2u);
    EXPECT_EQ(tokens[2].location.column, 8u);
    EXPECT_TRUE(tokens[2].spaceBefore);
}

TEST(Lexer, OldDebugLinesVanish) {
    const auto tokens =
        mustLex("@@DWARF .section .debug_info, \"\",@progbits\n@@DWARF .byte 1\nx @p");
    ASSERT_EQ(tokens.size(), 3u);
    EXPECT_EQ(tokens[0].text, "x");
}

TEST(Lexer, Strings) {
    const auto tokens = mustLex("\"a file\" \"es\\\"caped\" \"\"");
    ASSERT_EQ(tokens.size(), 3u);
    EXPECT_EQ(tokens[0].text, "a file");
    EXPECT_EQ(tokens[1].text, "es\\\"caped");
    EXPECT_EQ(tokens[2].text, "");
}

TEST(Lexer, FaultsEndTheText) {
    EXPECT_EQ(lexError("a /* b"), "error: line 1:3: this comment has no end: missing '*/'\n");
    EXPECT_EQ(lexError("\"abc\nd\""), "error: line 1:1: this string has no end: missing '\"'\n");
    EXPECT_EQ(lexError("\"abc\\"), "error: line 1:1: this string has no end: missing '\"'\n");
    EXPECT_EQ(lexError("a . b"), "error: line 1:3: a '.' without a word after it\n");
    EXPECT_EQ(lexError("a ` b"), "error: line 1:3: character '`' is not part of any PTX text\n");
    EXPECT_EQ(lexError("\n\xC3\xA4"), "error: line 2:1: byte 0xc3 is not part of any PTX text\n");
}

TEST(Lexer, ReadsDotNumbersAgain) {
    Diagnostics diagnostics;
    Lexer lexer(".5e-1;", diagnostics);
    const Token word = lexer.next();
    EXPECT_EQ(word.kind, TokenKind::kDotWord);
    const Token number = lexer.numberAt(word);
    EXPECT_EQ(std::bit_cast<double>(number.bits), 0.05);
    EXPECT_TRUE(lexer.next().is(';'));
}

TEST(Lexer, GoesBack) {
    Diagnostics diagnostics;
    Lexer lexer("a\n b\n c", diagnostics);
    lexer.next();
    const Token b = lexer.next();
    lexer.next();
    lexer.rewind(b);
    const Token again = lexer.next();
    EXPECT_EQ(again.text, "b");
    EXPECT_EQ(again.location.line, 2u);
    EXPECT_EQ(again.location.column, 2u);
    EXPECT_EQ(lexer.next().location.line, 3u);
}

} // namespace
} // namespace sunstone::ptx::testing
