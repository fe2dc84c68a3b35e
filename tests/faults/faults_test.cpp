// What goes wrong around the tool: full disk, read-only folder, too few files or too little memory, inputs that change
// while they are read, two writers of one file, a result that cannot be printed. The tool must say so in one line, exit
// with 1, keep the old output and leave nothing behind. Mounting needs root; without it those two cases are skipped.
// Does not prove it for every system call that can fail.
#include <sys/mount.h>

#include <array>
#include <atomic>
#include <thread>

#include "cli/bad_input.h"
#include "faults/writers.h"
#include "scatmap/base/error.h"
#include "scatmap/base/provenance.h"
#include "scatmap/frame/frame.h"

namespace scatmap::test {
namespace {

class Faults : public testing::Test {
 protected:
  Faults() : lab_(maker_.fresh_copy()) { complete(lab_); }

  // The run must fail in one line and leave the old output as it was.
  void expect_refused(const Writer& w, const ToolRun& run, const Content& old, const std::string& context) {
    EXPECT_EQ(run.status, 1) << w.name << ", " << context << ": " << run.err;
    EXPECT_TRUE(is_one_message(without_progress(run.err))) << w.name << ", " << context << ": " << run.err;
    EXPECT_EQ(content(lab_, w), old) << w.name << ", " << context;
    EXPECT_EQ(leftovers(lab_), std::vector<std::string>{}) << w.name << ", " << context;
  }
  static std::string without_progress(const std::string& err) {
    std::string out;
    std::istringstream lines(err);
    for (std::string line; std::getline(lines, line);) {
      if (!line.starts_with("measuring ")) out += line + "\n";
    }
    return out;
  }

  LabMaker maker_;
  Lab lab_;
};

// A tmpfs over a folder of the laboratory for as long as it lives.
class SmallDisk {
 public:
  SmallDisk(fs::path folder, const char* options, unsigned long flags = 0) : folder_(std::move(folder)) {
    fs::create_directories(folder_);
    mounted_ = mount("scatmap-test", folder_.c_str(), "tmpfs", flags, options) == 0;
  }
  ~SmallDisk() {
    if (mounted_) umount2(folder_.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  bool mounted() const { return mounted_; }
  bool make_read_only() const { return mount(nullptr, folder_.c_str(), nullptr, MS_REMOUNT | MS_RDONLY, nullptr) == 0; }

 private:
  fs::path folder_;
  bool mounted_ = false;
};

// The writer's output in `folder`.
Writer moved(Writer w, const std::string& folder) {
  const auto output = std::find(w.command.begin(), w.command.end(), "-o") + 1;
  *output = folder + "/" + *output;
  w.output = folder + "/" + w.output;
  return w;
}

TEST_F(Faults, FullDisk) {
  for (const Writer& original : writers()) {
    const Writer w = moved(original, "disk");
    const SmallDisk disk(lab_.path("disk"), "size=24k");
    if (!disk.mounted()) GTEST_SKIP() << "a small disk cannot be mounted: not root, or no right to";
    put_old(lab_, w);
    const Content old = content(lab_, w);
    // Filled to the last 4 KiB, so that the small text files do not fit either.
    std::ofstream filler(lab_.path("disk/filler"), std::ios::binary);
    while (fs::space(lab_.path("disk")).available > 4096 && filler.put('x').flush())
      filler << std::string(1023, 'x') << std::flush;
    filler.close();
    std::ofstream last(lab_.path("disk/last"), std::ios::binary);
    last << std::string(4096, 'x') << std::flush;
    last.close();
    expect_refused(w, RunningTool(w.command, lab_.folder()).wait(), old, "full disk");
  }
}

TEST_F(Faults, ReadOnlyFolder) {
  for (const Writer& original : writers()) {
    const Writer w = moved(original, "disk");
    const SmallDisk disk(lab_.path("disk"), "size=1m");
    if (!disk.mounted()) GTEST_SKIP() << "a disk cannot be mounted: not root, or no right to";
    put_old(lab_, w);
    const Content old = content(lab_, w);
    ASSERT_TRUE(disk.make_read_only());
    const ToolRun run = RunningTool(w.command, lab_.folder()).wait();
    expect_refused(w, run, old, "read-only");
    EXPECT_NE(run.err.find("cannot be written to"), std::string::npos) << run.err;
  }
}

TEST_F(Faults, FileThatMayNotGrow) {
#if defined(__SANITIZE_THREAD__)
  constexpr std::array<rlim_t, 1> kLimits{100};  // its run-time writes a file of its own before main
#else
  constexpr std::array<rlim_t, 2> kLimits{0, 100};
#endif
  for (const Writer& w : writers()) {
    for (const rlim_t bytes : kLimits) {
      put_old(lab_, w);
      const Content old = content(lab_, w);
      expect_refused(w, run_limited(w.command, lab_.folder(), {{}, {}, bytes}), old, std::to_string(bytes) + " bytes");
    }
  }
}

// Standard input, output and error are open; the tool needs a few more. Whatever it may not open, it says so.
TEST_F(Faults, TooFewFiles) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers open files of their own to look at memory, and take it for bad where they cannot";
#endif
  for (const Writer& w : writers()) {
    if (w.name == "chart") continue;  // as the others, and slow
    put_old(lab_, w);
    const Content old = content(lab_, w);
    int refused = 0;
    for (rlim_t files = 4; files < 32; ++files) {
      const ToolRun run = run_limited(w.command, lab_.folder(), {files, {}, {}});
      if (run.status == 0) break;
      constexpr int kLoaderFailed = 127;  // before main: the harness may hold files open that count too
      if (run.status == kLoaderFailed) continue;
      ++refused;
      expect_refused(w, run, old, std::to_string(files) + " files");
    }
    EXPECT_GT(refused, 0) << w.name;
  }
}

// From where the loader fails (its own message, status 127) to where the run succeeds.
TEST_F(Faults, TooLittleMemory) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers reserve terabytes of address space";
#endif
  std::string huge = lab_.read("instrument.toml");
  for (const char* key : {"columns = 64", "rows = 64"})
    huge.replace(huge.find(key), std::string(key).size(),
                 std::string(key).substr(0, std::string(key).find('=')) + "= 2048");
  lab_.write("big.toml", huge);
  for (const Writer& w : writers()) {
    if (w.name == "chart") continue;
    put_old(lab_, w);
    const Content old = content(lab_, w);
    int refused = 0;
    for (rlim_t mib = 64; mib < 4096; mib += mib / 8) {
      const ToolRun run = run_limited(w.command, lab_.folder(), {{}, mib << 20U, {}});
      if (run.status == 127) continue;
      if (run.status == 0) break;
      ++refused;
      expect_refused(w, run, old, std::to_string(mib) + " MiB");
    }
    std::printf("%s: refused %d times\n", w.name.c_str(), refused);
  }
}

TEST_F(Faults, ResultThatCannotBePrinted) {
  const std::string command =
      std::string("cd '") + lab_.folder().string() + "' && '" + SCATMAP_TOOL +
      "' angles instrument.toml --stage-deg 20 --arm-deg 40 --json -o p.fits > /dev/full 2> err";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_TRUE(is_one_message(lab_.read("err"))) << lab_.read("err");
}

TEST_F(Faults, TwoWritersOfOneFileDoNotMix) {
  const auto command = [](const char* arm) {
    return std::vector<std::string>{"angles", "big.toml", "--stage-deg", "20",     "--arm-deg",
                                    arm,      "-o",       "out.fits",    "--force"};
  };
  const Writer w{"FITS", {}, "out.fits", ""};
  std::set<Content> whole;
  for (const char* arm : {"40", "41"}) {
    ASSERT_EQ(RunningTool(command(arm), lab_.folder()).wait().status, 0);
    whole.insert(content(lab_, w));
  }
  ASSERT_EQ(whole.size(), 2u);
  for (int i = 0; i < 20; ++i) {
    RunningTool a(command("40"), lab_.folder()), b(command("41"), lab_.folder());
    EXPECT_EQ(a.wait().status, 0);
    EXPECT_EQ(b.wait().status, 0);
    EXPECT_TRUE(whole.contains(content(lab_, w)));
    EXPECT_EQ(leftovers(lab_), std::vector<std::string>{});
  }
}

TEST_F(Faults, OfTwoWritersWithoutForceOneIsRefused) {
  const std::vector<std::string> command{"angles",    "big.toml", "--stage-deg", "20",
                                         "--arm-deg", "40",       "-o",          "out.fits"};
  for (int i = 0; i < 10; ++i) {
    fs::remove(lab_.path("out.fits"));
    RunningTool a(command, lab_.folder()), b(command, lab_.folder());
    const ToolRun ra = a.wait(), rb = b.wait();
    EXPECT_EQ(ra.status + rb.status, 1) << ra.err << rb.err;
    EXPECT_NE((ra.err + rb.err).find("exists and is kept"), std::string::npos);
    EXPECT_EQ(leftovers(lab_), std::vector<std::string>{});
  }
}

TEST_F(Faults, TwoWritersOfOneFolderDoNotMix) {
  const Writer w{"simulate", {"simulate", "scene.toml", "-o", "simulated", "--force"}, "simulated", "truth/scene.toml"};
  put_old(lab_, w);
  ASSERT_EQ(RunningTool(w.command, lab_.folder()).wait().status, 0);
  const Content whole = content(lab_, w);
  for (int i = 0; i < 10; ++i) {
    RunningTool a(w.command, lab_.folder()), b(w.command, lab_.folder());
    const ToolRun ra = a.wait(), rb = b.wait();
    EXPECT_EQ(ra.status, 0) << ra.err;
    EXPECT_EQ(rb.status, 0) << rb.err;
    EXPECT_EQ(content(lab_, w), whole);
    EXPECT_EQ(leftovers(lab_), std::vector<std::string>{});
  }
}

// A file that is written all the time cannot be read in peace; what is read of it must not be passed off as a frame.
TEST_F(Faults, InputThatChangesWhileItIsRead) {
  const fs::path file = lab_.path("changing.pgm");
  const int side = 1500;
  const std::string bytes =
      "P5 " + std::to_string(side) + " " + std::to_string(side) + " 65535\n" + std::string(2 * side * side, 'a');
  lab_.write("changing.pgm", bytes);
  std::atomic<bool> stop{false}, first{false};
  std::thread writer([&] {
    const int fd = open(file.c_str(), O_WRONLY);
    for (char c = 'a'; !stop; c = c == 'a' ? 'b' : 'a') {
      if (pwrite(fd, &c, 1, 1000) != 1) break;
      first = true;
    }
    close(fd);
  });
  while (!first) std::this_thread::yield();
  // The writer must have had its turn while the file was read, and the file system's clock must have ticked.
  int noticed = 0;
  for (int i = 0; i < 500 && noticed < 3; ++i) {
    try {
      read_frame(file);
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("changed while it was read"), std::string::npos) << e.what();
      ++noticed;
    }
  }
  stop = true;
  writer.join();
  EXPECT_EQ(noticed, 3);
  EXPECT_NO_THROW(read_frame(file));
}

}  // namespace
}  // namespace scatmap::test
