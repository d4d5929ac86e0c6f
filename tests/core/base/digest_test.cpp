#include "core/base/digest.h"

#include <gtest/gtest.h>

namespace photond {
namespace {

// FIPS 180-4, examples.
TEST(Digest, MatchesTheStandard) {
  Hasher hasher;
  hasher.update("abc");
  EXPECT_EQ(to_hex(hasher.finish()), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(to_hex(sha256({})), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(Digest, HexRoundTripsAndRefusesWhatIsNotADigest) {
  const Digest digest = sha256({});
  EXPECT_EQ(digest_from_hex(to_hex(digest)), digest);
  EXPECT_FALSE(digest_from_hex("abc"));
  EXPECT_FALSE(digest_from_hex(std::string(63, '0') + "g"));
}

}  // namespace
}  // namespace photond
