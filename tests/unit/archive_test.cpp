#include "base/archive.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

#include "errors.hpp"
#include "results.hpp"

namespace calor {
namespace {

/// What an owner carries; its one list serves both ways.
struct Owner {
  std::vector<double> of_points, shares, few;
  double number = 0;
  long count = 0;
  bool flag = false;
  std::string text;

  void exchange(Archive& archive) {
    archive.value("number", number);
    archive.value("count", count);
    archive.value("flag", flag);
    archive.values("few", few);
    archive.text("text", text);
    archive.points("of points", of_points);
    archive.points("of points again", of_points);
    archive.shares("shares", shares);
  }
};

/// Points dealt out to the ranks like cards, the last ones first; some ranks may get none.
std::vector<std::int64_t> dealt(MPI_Comm comm, std::int64_t count) {
  std::vector<std::int64_t> id;
  for (std::int64_t n = count - 1 - rank_of(comm); n >= 0; n -= size_of(comm)) id.push_back(n);
  return id;
}

Owner owner_of(const std::vector<std::int64_t>& id, int rank) {
  Owner o{.of_points = {}, .shares = {1. / 3 + rank, 0.1}, .few = {}, .text = "a = b\n  c\n\nd"};
  for (const std::int64_t n : id) o.of_points.push_back(std::sin(static_cast<double>(n)) / 3);
  o.few = {1e-320, -0.0, std::numeric_limits<double>::infinity(), std::nan(""), 0.1};
  o.number = -std::numeric_limits<double>::max(), o.count = (1L << 53) - 1, o.flag = true;
  return o;
}

void expect_same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  ASSERT_EQ(a.size(), b.size());
  if (!a.empty()) {
    EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(double)), 0);
  }
}

TEST(ArchiveParallel, GivesBackTheBitsThatItWasGiven) {
  const TemporaryFolder folder(MPI_COMM_WORLD);
  const int rank = rank_of(MPI_COMM_WORLD);
  for (const std::int64_t count : {1, 2, 1000}) {
    const std::vector<std::int64_t> id = dealt(MPI_COMM_WORLD, count);
    const NumberedPoints points(MPI_COMM_WORLD, id);
    Owner written = owner_of(id, rank);
    ArchiveWriter writer(points);
    written.exchange(writer);
    writer.save(folder / "archive");

    Owner read{
        .of_points = std::vector<double>(id.size()), .shares = {0, 0}, .few = std::vector<double>(5), .text = ""};
    ArchiveReader reader(MPI_COMM_WORLD, folder / "archive");
    EXPECT_EQ(reader.count(), count);
    reader.distribute(points);
    read.exchange(reader);
    expect_same_bits(read.of_points, written.of_points);
    expect_same_bits(read.shares, written.shares);
    expect_same_bits(read.few, written.few);
    EXPECT_EQ(read.number, written.number);
    EXPECT_EQ(read.count, written.count);
    EXPECT_EQ(read.flag, written.flag);
    EXPECT_EQ(read.text, written.text);
    EXPECT_FALSE(std::filesystem::exists(folder / "archive.part"));
    MPI_Barrier(MPI_COMM_WORLD);
  }
}

TEST(ArchiveParallel, IsTheSameFileHoweverThePointsAreDistributedAndCanBeReadByOneRank) {
  const TemporaryFolder folder(MPI_COMM_WORLD), own;
  const auto file_of = [](MPI_Comm comm, const std::string& path) {
    const std::vector<std::int64_t> id = dealt(comm, 100);
    const NumberedPoints points(comm, id);
    Owner owner = owner_of(id, 0);
    owner.shares.clear();
    ArchiveWriter writer(points);
    owner.exchange(writer);
    writer.save(path);
    return read_file(path);
  };
  EXPECT_EQ(file_of(MPI_COMM_WORLD, folder / "archive"), file_of(MPI_COMM_SELF, own / "archive"));
}

TEST(ArchiveParallel, GivesAllSharesToTheFirstRankOfAnotherNumber) {
  const TemporaryFolder folder(MPI_COMM_WORLD);
  const int rank = rank_of(MPI_COMM_WORLD), ranks = size_of(MPI_COMM_WORLD);
  const std::vector<std::int64_t> id = dealt(MPI_COMM_WORLD, 10);
  const NumberedPoints points(MPI_COMM_WORLD, id);
  std::vector<double> shares{1.0 + rank};
  ArchiveWriter writer(points);
  writer.shares("shares", shares);
  writer.save(folder / "archive");
  ArchiveReader reader(MPI_COMM_SELF, folder / "archive");
  reader.shares("shares", shares);
  EXPECT_EQ(shares[0], ranks * (ranks + 1) / 2);
  MPI_Barrier(MPI_COMM_WORLD);
}

TEST(Archive, RefusesAFileOfWhichAnyByteHasChanged) {
  const TemporaryFolder folder;
  const std::vector<std::int64_t> id = dealt(MPI_COMM_SELF, 3);
  const NumberedPoints points(MPI_COMM_SELF, id);
  Owner owner = owner_of(id, 0);
  ArchiveWriter writer(points);
  owner.exchange(writer);
  const std::string path = folder / "archive";
  writer.save(path);
  const std::string good = read_file(path);
  const auto fault_with = [&](const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
    return error_of([&] { ArchiveReader(MPI_COMM_SELF, path); }).fault();
  };
  for (std::size_t n = 0; n < good.size(); ++n) {
    std::string bad = good;
    bad[n] ^= 1;
    EXPECT_EQ(fault_with(bad), Fault::file) << "byte " << n;
  }
  for (const std::size_t length : {std::size_t{0}, std::size_t{50}, good.size() - 1})
    EXPECT_EQ(fault_with(good.substr(0, length)), Fault::file);
  EXPECT_EQ(fault_with(good + "0"), Fault::file);
  EXPECT_EQ(fault_with(std::string(good.size(), '\0')), Fault::file);
}

TEST(Archive, RefusesToBeReadAsSomethingElse) {
  const TemporaryFolder folder;
  const std::vector<std::int64_t> id{0};
  const NumberedPoints points(MPI_COMM_SELF, id);
  double number = 1;
  ArchiveWriter writer(points);
  writer.value("a", number);
  writer.save(folder / "archive");
  ArchiveReader reader(MPI_COMM_SELF, folder / "archive");
  EXPECT_NE(std::string(error_of([&] { reader.value("b", number); }).what()).find("'b' does not come next"),
            std::string::npos);
  std::vector<double> two(2);
  EXPECT_EQ(error_of([&] { reader.values("a", two); }).fault(), Fault::file);
}

}  // namespace
}  // namespace calor
