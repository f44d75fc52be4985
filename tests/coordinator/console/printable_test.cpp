#include "coordinator/console/printable.hpp"

#include <gtest/gtest.h>
#include <string>

#include "common/chain/random.hpp"

namespace coppice {
namespace {

TEST(Printable, OrdinaryTextAndOtherScriptsStay) {
  for (const char* text : {"", "s3=0: expected move", "\u2192 caf\u00e9 \u6728", "\U0001F333"}) {
    EXPECT_EQ(printable(text), text);
  }
}

TEST(Printable, WhatATerminalObeysIsEscaped) {
  EXPECT_EQ(printable("a\x1b[31mb"), "a\\x1b[31mb");
  EXPECT_EQ(printable("a\nb\tc\r"), "a\\x0ab\\x09c\\x0d");
  EXPECT_EQ(printable(std::string_view("\0", 1)), "\\x00");
  EXPECT_EQ(printable("\x7f"), "\\x7f");
  EXPECT_EQ(printable("\u009b"), "\\xc2\\x9b");       // C1: control sequence introducer
  EXPECT_EQ(printable("\u202e"), "\\xe2\\x80\\xae");  // right-to-left override
  EXPECT_EQ(printable("\u2066x"), "\\xe2\\x81\\xa6x");
}

TEST(Printable, WhatIsNotUtf8IsEscapedByteByByte) {
  EXPECT_EQ(printable("\xff"), "\\xff");
  EXPECT_EQ(printable("\xc0\xaf"), "\\xc0\\xaf");           // overlong
  EXPECT_EQ(printable("\xe0\x80\xaf"), "\\xe0\\x80\\xaf");  // overlong
  EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80");  // surrogate
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");
  EXPECT_EQ(printable("\xe2\x86"), "\\xe2\\x86");  // cut off
  EXPECT_EQ(printable("\x9bx"), "\\x9bx");
}

TEST(Printable, AnyBytesBecomePrintableAndStaySo) {
  Stream random(7, Purpose::growing, 0, 0);
  for (int i = 0; i < 5000; ++i) {
    std::string bytes(random.below(12), '\0');
    for (char& byte : bytes) {
      byte = static_cast<char>(random.below(256));
    }
    const std::string shown = printable(bytes);
    EXPECT_EQ(printable(shown), shown);
    for (const char c : shown) {
      EXPECT_FALSE(static_cast<unsigned char>(c) < 0x20 || c == 0x7f);
    }
  }
}

}  // namespace
}  // namespace coppice
