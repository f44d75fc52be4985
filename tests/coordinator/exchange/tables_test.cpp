// Q-tables and policies that were made elsewhere.
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "coordinator/exchange/drn.hpp"
#include "coordinator/exchange/given_policy.hpp"
#include "coordinator/exchange/npy.hpp"
#include "tests/coordinator/exchange/sources.hpp"

namespace coppice {
namespace {

using testing::SourceFiles;

template <typename T>
std::string npy(const std::string& type, const std::string& shape, const std::vector<T>& values,
                const std::string& order = "False") {
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': ({}), }}", type, order, shape);
  header.resize(118, ' ');
  std::string bytes("\x93NUMPY\x01\x00", 8);
  bytes += static_cast<char>(header.size());
  bytes += '\0';
  bytes += header;
  const std::size_t at = bytes.size();
  bytes.resize(at + values.size() * sizeof(T));
  std::memcpy(bytes.data() + at, values.data(), values.size() * sizeof(T));
  return bytes;
}

TEST(Npy, ArraysOfEveryTypeAndOrderAreRead) {
  SourceFiles files;
  const std::vector<double> wanted{0, 1, 2, 3, 4, 5};
  EXPECT_EQ(read_npy(files.write("d.npy", npy<double>("<f8", "2, 3", wanted)))->values, wanted);
  EXPECT_EQ(read_npy(files.write("f.npy", npy<float>("<f4", "6,", {0, 1, 2, 3, 4, 5})))->values, wanted);
  EXPECT_EQ(read_npy(files.write("i.npy", npy<std::int64_t>("<i8", "3, 2", {0, 1, 2, 3, 4, 5})))->values, wanted);
  EXPECT_EQ(read_npy(files.write("u.npy", npy<std::uint8_t>("|u1", "6,", {0, 1, 2, 3, 4, 5})))->values, wanted);
  const auto fortran = read_npy(files.write("o.npy", npy<double>("<f8", "2, 3", {0, 3, 1, 4, 2, 5}, "True")));
  EXPECT_EQ(fortran->values, wanted);
  EXPECT_EQ(fortran->shape, (std::vector<std::size_t>{2, 3}));
}

TEST(Npy, WhatIsWrongIsNamed) {
  SourceFiles files;
  const auto refused = [&files](const std::string& bytes, const std::string& message) {
    const auto array = read_npy(files.write("bad.npy", bytes));
    ASSERT_FALSE(array.has_value()) << message;
    EXPECT_NE(array.error().message.find(message), std::string::npos) << array.error().message;
  };
  const std::string good = npy<double>("<f8", "2, 3", {0, 1, 2, 3, 4, 5});
  refused(good.substr(0, 20), "the header is not that of a NumPy array");
  refused(good.substr(0, good.size() - 1), "cut short");
  refused(good + "x", "foreign bytes");
  refused(npy<double>("<c16", "3,", {0, 1, 2, 3, 4, 5}), "an array of type '<c16'");
  refused(npy<double>(">f8", "6,", {0, 1, 2, 3, 4, 5}), "an array of type '>f8'");
  refused(npy<double>("<f8", "", {0}), "a single number");
  refused(npy<double>("<f8", "0,", {}), "shape (0)");
  refused(npy<double>("<f8", "4294967296, 4294967296", {0}), "shape (4294967296, 4294967296)");
  refused("PK\x03\x04 something", "no .npy file");
}

// Two places, one action lacking in the second.
Model small_model(SourceFiles& files) {
  return *read_drn(files.write("m.drn", R"(@type: MDP
@parameters

@reward_models

@nr_states
3
@nr_choices
5
@model
state 0 init
//[x=0 & y=2]
	action a
		1 : 1
	action b
		0 : 1
state 1
//[x=1 & y=0]
	action a
		2 : 1
	action b
		0 : 1
state 2
//[x=2 & y=1]
	action a
		0 : 1
)"),
                   "");
}

TEST(GivenPolicy, TablesByNumberAndByReadingsSayTheSame) {
  SourceFiles files;
  const Model model = small_model(files);
  std::vector<double> cube(3 * 3 * 2, 0.0);
  const auto at = [&cube](std::size_t x, std::size_t y, std::size_t a) -> double& { return cube[(x * 3 + y) * 2 + a]; };
  at(0, 2, 0) = 1;
  at(0, 2, 1) = 5;
  at(1, 0, 0) = 2;
  at(1, 0, 1) = 2;
  at(2, 1, 0) = -1;
  at(2, 1, 1) = 9;
  for (const std::string& path :
       {files.write("q.npy", npy<double>("<f8", "3, 2", {1, 5, 2, 2, -1, 9})),
        files.write("cube.npy", npy<double>("<f8", "3, 3, 2", cube)), files.write("bare.csv", "1,5\n2,2\n-1,9\n"),
        files.write("named.csv", "b,y,a,x,visits\n9,1,-1,2,7\n5,2,1,0,7\n2,0,2,1,7\n")}) {
    SCOPED_TRACE(path);
    const auto given = read_given_policy(path, "", model);
    ASSERT_TRUE(given.has_value()) << given.error().message;
    EXPECT_EQ(given->q, (std::vector<double>{1, 5, 2, 2, -1, 9}));
    // Greedy, ties to the lowest index, and never what the state lacks.
    EXPECT_EQ(given->policy, (std::vector<ActionId>{ActionId{1}, ActionId{0}, ActionId{0}}));
    EXPECT_EQ(given->ties, 1U);
    EXPECT_EQ(given->unlisted, 0U);
  }
  for (const std::string& path :
       {files.write("p.npy", npy<std::int32_t>("<i4", "3,", {1, 1, 0})), files.write("p.csv", "1\n1\n0\n"),
        files.write("pn.csv", "x,y,action\n0,2,b\n1,0,1\n2,1,a\n")}) {
    SCOPED_TRACE(path);
    const auto given = read_given_policy("", path, model);
    ASSERT_TRUE(given.has_value()) << given.error().message;
    EXPECT_EQ(given->policy, (std::vector<ActionId>{ActionId{1}, ActionId{1}, ActionId{0}}));
  }
}

TEST(GivenPolicy, ForbiddenActionsLoseTheirRowsAndUnknownStatesAreCounted) {
  SourceFiles files;
  Model model = small_model(files);
  const auto given = read_given_policy(files.write("q.csv", "x,y,a,b\n0,2,-inf,5\n1,0,nan,0\n"), "", model);
  ASSERT_TRUE(given.has_value()) << given.error().message;
  EXPECT_EQ(given->unlisted, 1U);
  EXPECT_EQ(given->unvisited, 1U);
  EXPECT_EQ(given->policy, (std::vector<ActionId>{ActionId{1}, ActionId{1}, ActionId{0}}));
  ASSERT_TRUE(forbid(*given, model).has_value());
  EXPECT_EQ(model.row_begin, (std::vector<std::uint64_t>{0, 0, 1, 1, 2, 3, 3}));
  EXPECT_EQ(model.successor, (std::vector<std::uint32_t>{0, 0, 0}));
  const auto all = read_given_policy(files.write("none.csv", "x,y,a,b\n2,1,-inf,3\n"), "", model);
  EXPECT_NE(forbid(*all, model).error().message.find("forbids every action that state 2 has"), std::string::npos);
}

TEST(GivenPolicy, WhatIsWrongIsNamed) {
  SourceFiles files;
  const Model model = small_model(files);
  const auto refused = [&](const std::string& q, const std::string& policy, const std::string& message) {
    const auto given = read_given_policy(q, policy, model);
    ASSERT_FALSE(given.has_value()) << message;
    EXPECT_NE(given.error().message.find(message), std::string::npos) << given.error().message;
  };
  refused(files.write("a.csv", "1,2,3\n1,2,3\n1,2,3\n"), "", "expected the last to be 2");
  refused(files.write("b.csv", "1,2\n1,2\n"), "", "expected 3 states or more");
  refused(files.write("c.csv", "1,2\n1\n1,2\n"), "", "c.csv: line 2: 1 fields: expected 2");
  refused(files.write("d.csv", "x,a,b\n0,1,2\n"), "", "no column 'y'");
  refused(files.write("e.csv", "x,y,a\n0,1,2\n"), "", "no column 'b'");
  refused(files.write("f.csv", "x,y,a,b\n0,2,1,z\n"), "", "f.csv: line 2: found 'z'");
  refused(files.write("g.csv", "x,y,a,b\n0,2,1,2\n0,2,1,2\n"), "", "have a line already");
  refused(files.write("h.csv", "1,2\n1,inf\n1,2\n"), "", "is infinite");
  refused("", files.write("i.csv", "0\n3\n0\n"), "state 1 has action 3");
  refused("", files.write("j.csv", "0\n0\n1\n"), "state 2 has action b, which the state lacks");
  refused("", files.write("k.csv", ""), "no numbers");
}

}  // namespace
}  // namespace coppice
