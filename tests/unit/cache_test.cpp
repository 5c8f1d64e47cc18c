// Results that are kept: a second call reads what the first has made, to the last bit, or makes it anew.
#include "base/cache.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "base/parallel.hpp"
#include "results.hpp"

namespace calor {
namespace {

/// The part of this rank; ranks have different numbers of them, some none.
struct Part {
  std::vector<double> values, few;
  bool operator==(const Part&) const = default;
};
Part part_of(int rank) {
  Part part{.values = {}, .few = {1e-320, -1. / 3}};
  for (int n = 0; n < 100 * (rank % 3); ++n) part.values.push_back(std::sin(n + rank));
  return part;
}

/// Asks a new Cache of this folder for the parts, and tells whether they were made. Collective.
bool makes(const std::string& folder, std::vector<std::string>& notes, Cache::Owner owner = Cache::Owner::rank,
           int seed = 0) {
  const int rank = owner == Cache::Owner::rank ? rank_of(MPI_COMM_WORLD) : 2;
  Fingerprint from;
  from.add(seed).add(rank);
  Part part{.values = {7}, .few = {}};
  bool made = false;
  Cache cache(folder);
  cache.get(MPI_COMM_WORLD, "parts", owner, from, {&part.values, &part.few}, [&] {
    EXPECT_EQ(part, (Part{.values = {7}, .few = {}}));  // as it was, whatever the file may hold
    made = true;
    part = part_of(rank);
  });
  EXPECT_EQ(part, part_of(rank));
  notes = cache.notes();
  MPI_Barrier(MPI_COMM_WORLD);
  return made;
}

std::vector<std::string> files_in(const std::string& folder) {
  std::vector<std::string> files;
  for (const auto& file : std::filesystem::directory_iterator(folder)) files.push_back(file.path().string());
  std::ranges::sort(files);
  return files;
}

TEST(CacheParallel, ReadsWhatAnEarlierCallHasMadeOfTheSame) {
  const TemporaryFolder folder(MPI_COMM_WORLD);
  const std::string cache = folder / "a/b";
  std::vector<std::string> notes;
  EXPECT_TRUE(makes(cache, notes));
  EXPECT_TRUE(notes.empty());
  EXPECT_FALSE(makes(cache, notes));
  ASSERT_EQ(notes.size(), 1);
  EXPECT_TRUE(notes[0].starts_with("parts read from " + cache)) << notes[0];
  // What one rank alone has from elsewhere is another result for all.
  EXPECT_TRUE(makes(cache, notes, Cache::Owner::rank, rank_of(MPI_COMM_WORLD) == size_of(MPI_COMM_WORLD) - 1));
  EXPECT_EQ(files_in(cache).size(), 2 * size_of(MPI_COMM_WORLD));
}

TEST(CacheParallel, KeepsWhatAllRanksHaveInOneFile) {
  const TemporaryFolder folder(MPI_COMM_WORLD);
  std::vector<std::string> notes;
  EXPECT_TRUE(makes(folder.path(), notes, Cache::Owner::all));
  EXPECT_FALSE(makes(folder.path(), notes, Cache::Owner::all));
  EXPECT_EQ(files_in(folder.path()).size(), 1);
}

TEST(CacheParallel, MakesAnewWhereTheFileOfOneRankIsDamagedOrGone) {
  const TemporaryFolder folder(MPI_COMM_WORLD);
  const bool is_first = rank_of(MPI_COMM_WORLD) == 0;
  std::vector<std::string> notes;
  EXPECT_TRUE(makes(folder.path(), notes));
  const std::string file = files_in(folder.path()).back();
  const std::string good = read_file(file);
  MPI_Barrier(MPI_COMM_WORLD);
  std::vector<std::string> damaged = {good.substr(0, good.size() - 1), good + "0", "", "not of this kind"};
  for (const std::size_t byte : {std::size_t{0}, std::size_t{17}, std::size_t{30}, std::size_t{45}, std::size_t{58},
                                 good.size() - 17, good.size() - 1}) {
    damaged.push_back(good);
    damaged.back()[byte] ^= 1;
  }
  for (const std::string& bytes : damaged) {
    if (is_first) std::ofstream(file, std::ios::binary) << bytes;
    MPI_Barrier(MPI_COMM_WORLD);
    EXPECT_TRUE(makes(folder.path(), notes));
    ASSERT_EQ(notes.size(), 1);
    EXPECT_EQ(notes[0], file + ": is damaged, parts made anew");
    EXPECT_EQ(read_file(file), good);
    MPI_Barrier(MPI_COMM_WORLD);
  }
  if (is_first) std::filesystem::remove(file);
  MPI_Barrier(MPI_COMM_WORLD);
  EXPECT_TRUE(makes(folder.path(), notes));
  EXPECT_FALSE(makes(folder.path(), notes));
}

TEST(CacheParallel, SaysWhereItCannotWriteAndGoesOn) {
  const TemporaryFolder folder(MPI_COMM_WORLD);
  folder.write("file", "");
  std::vector<std::string> notes;
  for (int run = 0; run < 2; ++run) {
    EXPECT_TRUE(makes(folder / "file", notes));
    ASSERT_EQ(notes.size(), 1);
    EXPECT_EQ(notes[0], folder / "file" + ": Not a directory, parts not kept");
  }
}

TEST(Fingerprint, TellsArraysApartThatDifferInTheirBordersAlone) {
  const std::vector<double> none, one = {1}, two = {1, 2}, last = {2};
  const auto digest = [](const std::vector<double>& a, const std::vector<double>& b) {
    return Fingerprint().add(a).add(b).digest();
  };
  EXPECT_EQ(digest(one, last), digest(one, last));
  EXPECT_NE(digest(one, last), digest(two, none));
  EXPECT_NE(digest(one, last), digest(none, two));
}

}  // namespace
}  // namespace calor
