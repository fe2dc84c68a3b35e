// Outputs appear whole or not at all, number texts keep every bit, checksums are SHA-256, changed inputs are noticed.
// Kills and full disks: tests/faults.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <random>
#include <thread>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/output_file.h"
#include "scatmap/base/output_folder.h"
#include "scatmap/base/provenance.h"
#include "scatmap/base/temporary_folder.h"
#include "scatmap/base/units.h"

namespace scatmap {
namespace {
namespace fs = std::filesystem;

class Files : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("scatmap-files-" + std::to_string(getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::size_t entries() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  fs::path folder_;
};

TEST_F(Files, DroppedOutputLeavesNothing) {
  try {
    OutputFile out(folder_ / "a.txt", Overwrite::kKeep);
    std::ofstream(out.temporary()) << "half";
    throw 1;
  } catch (int) {
  }
  EXPECT_EQ(entries(), 0u);
}

TEST_F(Files, CommittedOutputIsWholeAndAlone) {
  write_text_file(folder_ / "a.txt", "all of it", Overwrite::kKeep);
  EXPECT_EQ(read_text_file(folder_ / "a.txt"), "all of it");
  EXPECT_EQ(entries(), 1u);
}

TEST_F(Files, ExistingFileIsKeptUnlessForced) {
  write_text_file(folder_ / "a.txt", "old", Overwrite::kKeep);
  EXPECT_THROW(write_text_file(folder_ / "a.txt", "new", Overwrite::kKeep), Error);
  EXPECT_EQ(read_text_file(folder_ / "a.txt"), "old");
  write_text_file(folder_ / "a.txt", "new", Overwrite::kForce);
  EXPECT_EQ(read_text_file(folder_ / "a.txt"), "new");
  EXPECT_EQ(entries(), 1u);
}

TEST_F(Files, FoldersMissingFoldersAndDanglingLinksAreRefused) {
  EXPECT_THROW(OutputFile(folder_, Overwrite::kForce), Error);
  EXPECT_THROW(OutputFile(folder_ / "no" / "a.txt", Overwrite::kForce), Error);
  fs::create_symlink("nowhere", folder_ / "link");
  EXPECT_THROW(OutputFile(folder_ / "link", Overwrite::kKeep), Error);
}

TEST_F(Files, FolderAppearsWholeAndReplacesOnlyItsOwnKind) {
  const auto make = [&](Overwrite overwrite, const char* text) {
    OutputFolder out(folder_ / "d", "marker.txt", overwrite);
    std::ofstream(out.temporary() / "marker.txt") << text;
    out.commit();
  };
  make(Overwrite::kKeep, "1");
  EXPECT_THROW(make(Overwrite::kKeep, "2"), Error);
  make(Overwrite::kForce, "3");
  EXPECT_EQ(read_text_file(folder_ / "d" / "marker.txt"), "3");
  fs::create_directories(folder_ / "mine");
  std::ofstream(folder_ / "mine" / "data") << "x";
  EXPECT_THROW(OutputFolder(folder_ / "mine", "marker.txt", Overwrite::kForce), Error);
  EXPECT_EQ(read_text_file(folder_ / "mine" / "data"), "x");
  EXPECT_EQ(entries(), 2u);
}

// Of another thread, or of gnuplot, whose working folder it is.
TEST_F(Files, WhatIsWrittenWhileAProcessEndsGoesToo) {
  folder_ /= "ends";
  fs::create_directory(folder_);
  constexpr int kTries = 5;  // chance decides whether a file arrives between the last look and the folder's end
  for (int turn = 0; turn < kTries; ++turn) {
    const pid_t child = fork();
    if (child == 0) {
      const TemporaryFolder mine(folder_, "a.txt");
      const int inside = open(mine.path().c_str(), O_RDONLY | O_DIRECTORY);
      std::thread late([inside] {
        const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(60);
        for (int i = 0; std::chrono::steady_clock::now() < end; ++i)
          close(openat(inside, std::to_string(i).c_str(), O_CREAT | O_WRONLY, 0600));
      });
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      abandon_temporary_folders();
      late.join();
      _exit(0);
    }
    waitpid(child, nullptr, 0);
    EXPECT_EQ(entries(), 0u);
  }
}

// What a killed process left goes with the next output; what a living one works in stays, and what is not ours too.
TEST_F(Files, LeftoversGoAndWorkInProgressStays) {
  folder_ /= "never used before";  // a process looks for leftovers once in every folder
  fs::create_directory(folder_);
  std::array<int, 2> ready{}, done{};
  ASSERT_EQ(pipe(ready.data()) + pipe(done.data()), 0);
  const auto child = [&](bool stays) {
    const pid_t pid = fork();
    if (pid != 0) return pid;
    close(done[1]);  // or the end of the pipe would wait for this process itself
    OutputFile out(folder_ / "a.txt", Overwrite::kKeep);
    std::ofstream(out.temporary()) << "half";
    char c = 'x';
    if (write(ready[1], &c, 1) != 1 || (stays && read(done[0], &c, 1) < 0)) _exit(1);
    _exit(0);  // as killed: nothing is cleaned up
  };
  const pid_t dead = child(false);
  waitpid(dead, nullptr, 0);
  const pid_t living = child(true);
  std::array<char, 2> both{};
  for (char& c : both) ASSERT_EQ(read(ready[0], &c, 1), 1);
  fs::create_directory(folder_ / ".scatmap-theirs");
  std::ofstream(folder_ / ".scatmap-tmp-file") << "a file, not a folder";
  const pid_t next = fork();  // another process: one looks for leftovers once only
  if (next == 0) {
    write_text_file(folder_ / "b.txt", "b", Overwrite::kKeep);
    _exit(0);
  }
  waitpid(next, nullptr, 0);
  EXPECT_TRUE(fs::exists(folder_ / "b.txt"));
  EXPECT_TRUE(fs::exists(folder_ / ".scatmap-theirs"));
  EXPECT_TRUE(fs::exists(folder_ / ".scatmap-tmp-file"));
  EXPECT_EQ(entries(), 4u) << "b.txt, two that are not ours, and the living process's";
  const char over = 'x';
  ASSERT_EQ(write(done[1], &over, 1), 1);
  waitpid(living, nullptr, 0);
  for (const int fd : {ready[0], ready[1], done[0], done[1]}) close(fd);
}

TEST_F(Files, OtherProcessesWriteBetweenCheckAndRename) {
  OutputFile out(folder_ / "a.txt", Overwrite::kKeep);
  std::ofstream(out.temporary()) << "mine";
  std::ofstream(folder_ / "a.txt") << "theirs";
  EXPECT_THROW(rename_whole(out.temporary(), folder_ / "a.txt", Overwrite::kKeep), Error);
  EXPECT_EQ(read_text_file(folder_ / "a.txt"), "theirs");
}

TEST_F(Files, InputThatChangedIsNoticed) {
  const fs::path file = folder_ / "in";
  std::ofstream(file) << "one";
  const FileState before = file_state(file);
  EXPECT_NO_THROW(record_input(file, before));
  std::ofstream(file) << "longer";
  EXPECT_THROW(record_input(file, before), Error);
  const FileState longer = file_state(file);
  write_text_file(file, "other!", Overwrite::kForce);  // as long as before, another file
  EXPECT_THROW(require_unchanged(file, longer), Error);
  fs::remove(file);
  EXPECT_THROW(require_unchanged(file, longer), Error);
}

TEST_F(Files, Sha256OfFips180Examples) {
  write_text_file(folder_ / "abc", "abc", Overwrite::kKeep);
  EXPECT_EQ(record_input(folder_ / "abc").sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  write_text_file(folder_ / "million", std::string(1000000, 'a'), Overwrite::kKeep);
  EXPECT_EQ(record_input(folder_ / "million").sha256,
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(NumberText, ReadsBackBitForBit) {
  std::mt19937_64 rng(3);
  for (int i = 0; i < 100000; ++i) {
    double v = 0;
    const std::uint64_t bits = rng();
    std::memcpy(&v, &bits, sizeof v);
    if (!std::isfinite(v)) continue;
    const double back = std::strtod(number_text(v).c_str(), nullptr);
    EXPECT_EQ(std::memcmp(&back, &v, sizeof v), 0);
  }
  EXPECT_EQ(number_text(325), "325");
  EXPECT_EQ(number_text(-0.0), "-0.0");
}

TEST(NumberText, InUnitsEveryValueFromAFileComesBack) {
  std::mt19937_64 rng(4);
  for (int i = 0; i < 100000; ++i) {
    const double in_file = std::uniform_real_distribution<double>(-1e3, 1e3)(rng);
    for (const double unit : {kMetrePerMm, kMetrePerUm, kRadPerDeg}) {
      const double inside = in_file * unit;
      EXPECT_EQ(std::strtod(number_text_in_unit(inside, unit).c_str(), nullptr) * unit, inside);
    }
  }
}

}  // namespace
}  // namespace scatmap
