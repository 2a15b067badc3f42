#include "comm/hdf5_file.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "base/error.hpp"
#include "base/system_file.hpp"
#include "comm/hdf5_memory.hpp"
#include "comm/seal.hpp"

namespace berm {
namespace {

constexpr const char* format_name = "berm checkpoint";
// Arrays are written as they stand in memory.
static_assert(std::endian::native == std::endian::little);

/// An HDF5 identifier, closed at the end of the scope.
class Id {
public:
  Id(hid_t id, herr_t (*close_it)(hid_t)) : id_(id), close_(close_it) {}
  Id(Id&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Id& operator=(Id&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Id() { close(); }

  bool close() { return id_ < 0 || close_(std::exchange(id_, H5I_INVALID_HID)) >= 0; }
  bool valid() const { return id_ >= 0; }
  operator hid_t() const { return id_; }

private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

Id properties(hid_t kind) { return {H5Pcreate(kind), H5Pclose}; }
Id no_file() { return {H5I_INVALID_HID, H5Fclose}; }

/// What the operating system said, from HDF5's stack of errors, else HDF5's innermost words. The next call to HDF5
/// clears the stack.
std::string reason() {
  std::string text;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned, const H5E_error2_t* error, void* out) -> herr_t {
        auto& found = *static_cast<std::string*>(out);
        if (!found.empty() || !error->desc) return 0;
        const std::string words = error->desc, mark = "error message = '";
        const auto begin = words.find(mark);
        found = begin == std::string::npos
                    ? words
                    : words.substr(begin + mark.size(), words.find('\'', begin + mark.size()) - begin - mark.size());
        return 0;
      },
      &text);
  return text.empty() ? "HDF5 gives no reason" : text;
}

/// Types as they stand in the file, and in memory.
struct Type {
  hid_t file, memory;
  const char* words;
};
Type type_of(const double*) { return {H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, "real numbers"}; }
Type type_of(const std::int64_t*) { return {H5T_STD_I64LE, H5T_NATIVE_INT64, "64-bit integers"}; }
Type type_of(const std::int32_t*) { return {H5T_STD_I32LE, H5T_NATIVE_INT32, "32-bit integers"}; }
Type type_of(const std::uint8_t*) { return {H5T_STD_U8LE, H5T_NATIVE_UINT8, "bytes"}; }

void start_hdf5() {
  H5dont_atexit();  // MPI or the end of the process are early enough
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // its errors become ours
}

/// A file of the operating system, closed at the end of the scope.
class Descriptor {
public:
  Descriptor() = default;
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(const std::string& path, int flags) : fd_(::open(path.c_str(), flags | O_CLOEXEC)) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Descriptor() { close(); }

  int close() { return fd_ < 0 ? 0 : ::close(std::exchange(fd_, -1)); }
  operator int() const { return fd_; }

private:
  int fd_ = -1;
};

/// The folder entry too must reach the disk. A file system that cannot do that for folders is no error.
void sync_folder(const std::string& path) {
  const auto folder = std::filesystem::path(path).parent_path();
  ::fsync(Descriptor(folder.empty() ? "." : folder.string(), O_RDONLY | O_DIRECTORY));
}

}  // namespace

// HDF5 runs on the root alone and lays out the file, in memory (hdf5_memory.hpp); every process then writes its rows where
// they belong with calls of the operating system, and the root at last what HDF5 has to say. MPI-IO would do the same, but on
// a full disk Open MPI 4.1 (OMPIO and ROMIO) loses the error or waits for ever.
struct CheckpointFile::Impl {
  Comm comm;
  std::string path;
  bool writing = false;  ///< until committed
  Hdf5Memory tables;     ///< root, writing: what HDF5 has written
  Id file = no_file();
  Descriptor rows;  ///< writing: the file on the disk

  ~Impl() {
    if (writing && comm.is_root()) std::remove(draft().c_str());
  }

  std::string draft() const { return path + ".part"; }

  [[noreturn]] void fail_write(const std::string& why) const {
    throw RunError(fmt::format("cannot write {}: {}", path, why));
  }
  [[noreturn]] void fail_read(const std::string& why) const {
    throw InputError(fmt::format("{} is not a checkpoint of berm: {}", path, why));
  }
  [[noreturn]] void fail_content(const std::string& name, const std::string& why) const {
    throw InputError(fmt::format("{}: {} {}", path, name, why));
  }

  void on_root(const std::function<void()>& work) {
    comm.agree([&] {
      if (comm.is_root()) work();
    });
  }

  /// For results of HDF5 while writing: throws if negative.
  void check(std::int64_t result) const {
    if (result < 0) fail_write(reason());
  }
  /// The same for the operating system.
  void check_system(std::int64_t result) const {
    if (result < 0) fail_write(system_reason(errno));
  }

  void must_write() const {
    if (!writing) throw std::logic_error(path + ": the checkpoint is not open for writing");
  }

  void begin() {
    on_root([&] {
      rows = Descriptor(open_new_file(draft()));
      check_system(rows);
      writing = true;
      const Id access(access_to_memory(tables), H5Pclose), creation = properties(H5P_FILE_CREATE);
      check(access);
      H5Pset_userblock(creation, seal_size);
      file = Id(H5Fcreate(draft().c_str(), H5F_ACC_TRUNC, creation, access), H5Fclose);
      check(file);
    });
    writing = true;
    comm.agree([&] {
      if (!comm.is_root()) rows = Descriptor(draft(), O_WRONLY | O_NOFOLLOW);
      check_system(rows);
    });
  }

  void check_seal() const {
    try {
      if (const std::string broken = broken_seal(path); !broken.empty()) fail_read(broken);
    } catch (const std::system_error& error) {
      throw InputError(fmt::format("cannot read {}: {}", path, error.code().message()));
    }
  }

  /// Before anybody opens it.
  void look() const {
    if (::access(path.c_str(), R_OK) != 0) throw InputError(fmt::format("cannot read {}: {}", path, strerror(errno)));
    if (std::filesystem::is_directory(path)) throw InputError(fmt::format("cannot read {}: it is a folder", path));
    if (H5Fis_hdf5(path.c_str()) <= 0) fail_read("it is no HDF5 file");
    if (comm.is_root()) check_seal();
  }

  void open() {
    // Every process opens it with the plain driver: reading then needs no agreement on who reads what when.
    const Id access = properties(H5P_FILE_ACCESS);
    H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
    H5Pset_file_locking(access, true, true);
    file = Id(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access), H5Fclose);
    if (!file.valid()) fail_read(fmt::format("the HDF5 file is incomplete or damaged ({})", reason()));
    if (!is_marked()) fail_read(fmt::format("the HDF5 file lacks the mark \"{}\"", format_name));
    const double version = read_number("version");
    if (version != checkpoint_version)
      throw InputError(fmt::format("{} is a checkpoint in version {} of the format, from {} berm; this one reads version {}", path,
                                   version, version > checkpoint_version ? "a later" : "an earlier", checkpoint_version));
  }

  void write(const std::string& name, Type type, const std::byte* mine, std::size_t n_values, int columns) {
    must_write();
    if (columns < 1 || n_values % columns != 0)
      throw std::logic_error(fmt::format("{}: {} values are not rows of {}", name, n_values, columns));
    const long n = static_cast<long>(n_values / columns);
    const long begin = comm.exclusive_sum(n);
    const std::array<hsize_t, 2> shape{static_cast<hsize_t>(comm.sum(n)), static_cast<hsize_t>(columns)};
    std::int64_t offset = 0;
    on_root([&] {
      const Id space(H5Screate_simple(2, shape.data(), nullptr), H5Sclose);
      const Id set = create(name, type.file, space);
      offset = static_cast<std::int64_t>(H5Dget_offset(set));
    });
    const std::size_t value_size = H5Tget_size(type.memory);
    offset = comm.broadcast(offset) + begin * columns * static_cast<long>(value_size);
    comm.agree([&] { write_bytes(reinterpret_cast<const char*>(mine), n_values * value_size, offset); });
  }

  /// A table that has its place in the file, without values.
  Id create(const std::string& name, hid_t type, hid_t space) {
    const Id link = properties(H5P_LINK_CREATE), creation = properties(H5P_DATASET_CREATE);
    H5Pset_create_intermediate_group(link, 1);
    H5Pset_alloc_time(creation, H5D_ALLOC_TIME_EARLY);
    H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER);
    Id set(H5Dcreate2(file, name.c_str(), type, space, link, creation, H5P_DEFAULT), H5Dclose);
    check(set);
    return set;
  }

  void write_bytes(const char* data, std::size_t size, std::int64_t offset) const {
    while (size > 0) {
      const ssize_t n = ::pwrite(rows, data, size, offset);
      if (n < 0 && errno == EINTR) continue;
      check_system(n);
      data += n;
      size -= static_cast<std::size_t>(n);
      offset += n;
    }
  }

  void write_text(const std::string& name, const std::string& text) {
    must_write();
    on_root([&] {
      // A fixed-length string, not an attribute: those end at 64 KiB.
      const Id type(H5Tcopy(H5T_C_S1), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
      H5Tset_size(type, std::max<std::size_t>(1, text.size()));
      H5Tset_strpad(type, H5T_STR_NULLPAD);
      H5Tset_cset(type, H5T_CSET_UTF8);
      check(H5Dwrite(create(name, type, space), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.c_str()));
    });
  }

  void write_attribute(const std::string& name, Type type, const void* value) {
    must_write();
    on_root([&] {
      const Id space(H5Screate(H5S_SCALAR), H5Sclose);
      const Id attribute(H5Acreate2(file, name.c_str(), type.file, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
      check(attribute);
      check(H5Awrite(attribute, type.memory, value));
    });
  }

  void seal() const {
    std::string words;
    try {
      words = seal_of(draft());
    } catch (const std::system_error& error) {
      fail_write(system_reason(error.code().value()));
    }
    const Descriptor head(draft(), O_WRONLY | O_NOFOLLOW);
    check_system(head);
    check_system(::pwrite(head, words.data(), words.size(), 0));
    check_system(::fsync(head));
  }

  void commit() {
    must_write();
    on_root([&] {
      check(file.close() ? 0 : -1);
      check_system(::ftruncate(rows, static_cast<off_t>(tables.room)));
      tables.for_each_part([&](std::uint64_t at, std::span<const char> part) {
        write_bytes(part.data(), part.size(), static_cast<std::int64_t>(at));
      });
    });
    comm.agree([&] {
      check_system(::fsync(rows));
      check_system(rows.close());
    });
    on_root([&] {
      seal();
      check_system(std::rename(draft().c_str(), path.c_str()));
      sync_folder(path);
    });
    writing = false;
  }

  bool is_marked() const {
    try {
      return read_text("format") == format_name && read_number("version") > 0.0;
    } catch (const InputError&) {
      return false;
    }
  }

  bool has(const std::string& name) const {
    // HDF5 wants every folder on the way to exist before it answers.
    for (auto end = name.find('/'); end != std::string::npos; end = name.find('/', end + 1))
      if (end > 0 && H5Lexists(file, name.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
    return H5Lexists(file, name.c_str(), H5P_DEFAULT) > 0;
  }

  Id dataset(const std::string& name) const {
    if (!has(name)) fail_content(name, "is missing");
    Id set(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose);
    if (!set.valid()) fail_content(name, "cannot be opened: " + reason());
    return set;
  }

  /// Rows and columns of a table.
  std::array<hsize_t, 2> shape(const std::string& name, hid_t set) const {
    const Id space(H5Dget_space(set), H5Sclose);
    std::array<hsize_t, 2> n{};
    if (H5Sget_simple_extent_ndims(space) != 2) fail_content(name, "is not a table of rows and columns");
    H5Sget_simple_extent_dims(space, n.data(), nullptr);
    return n;
  }

  void read(const std::string& name, Type type, std::int64_t first, std::int64_t n, int columns,
            const std::function<void*()>& room) const {
    const Id set = dataset(name);
    const auto [height, width] = shape(name, set);
    const Id stored(H5Dget_type(set), H5Tclose);
    if (H5Tequal(stored, type.file) <= 0) fail_content(name, fmt::format("does not hold {}", type.words));
    if (width != hsize_t(columns)) fail_content(name, fmt::format("has {} columns, not {}", width, columns));
    if (first < 0 || n < 0 || hsize_t(first) > height || hsize_t(n) > height - first)
      fail_content(name, fmt::format("has {} rows, not rows {} to {}", height, first, first + n));
    if (n == 0) return;
    if (double(n) * double(width) * H5Tget_size(type.memory) > double(std::filesystem::file_size(path)))
      fail_content(name, "is larger than the file");
    const std::array<hsize_t, 2> at{hsize_t(first), 0}, part{hsize_t(n), width};
    const Id space(H5Dget_space(set), H5Sclose), memory(H5Screate_simple(2, part.data(), nullptr), H5Sclose);
    H5Sselect_hyperslab(space, H5S_SELECT_SET, at.data(), nullptr, part.data(), nullptr);
    if (H5Dread(set, type.memory, memory, space, H5P_DEFAULT, room()) < 0)
      fail_content(name, "cannot be read: " + reason());
  }

  std::string read_text(const std::string& name) const {
    const Id set = dataset(name);
    const Id type(H5Dget_type(set), H5Tclose), space(H5Dget_space(set), H5Sclose);
    if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) > 0 || H5Sget_simple_extent_npoints(space) != 1)
      fail_content(name, "is not a text");
    std::string text(H5Tget_size(type), '\0');
    if (H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()) < 0)
      fail_content(name, "cannot be read: " + reason());
    text.resize(text.find_last_not_of('\0') + 1);
    return text;
  }

  double read_number(const std::string& name) const {
    if (H5Aexists(file, name.c_str()) <= 0) fail_content(name, "is missing");
    const Id attribute(H5Aopen(file, name.c_str(), H5P_DEFAULT), H5Aclose);
    const Id space(H5Aget_space(attribute), H5Sclose), type(H5Aget_type(attribute), H5Tclose);
    if (H5Sget_simple_extent_npoints(space) != 1 ||
        (H5Tget_class(type) != H5T_FLOAT && H5Tget_class(type) != H5T_INTEGER))
      fail_content(name, "is not a number");
    double value = 0.0;
    if (H5Aread(attribute, H5T_NATIVE_DOUBLE, &value) < 0) fail_content(name, "cannot be read: " + reason());
    return value;
  }
};

CheckpointFile::CheckpointFile(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
CheckpointFile::CheckpointFile(CheckpointFile&&) noexcept = default;
CheckpointFile& CheckpointFile::operator=(CheckpointFile&&) noexcept = default;
CheckpointFile::~CheckpointFile() = default;

CheckpointFile CheckpointFile::create(const Comm& comm, const std::string& path) {
  start_hdf5();
  auto impl = std::make_unique<Impl>();
  impl->comm = comm;
  impl->path = path;
  impl->begin();
  impl->write_text("format", format_name);
  const std::int32_t version = checkpoint_version;
  impl->write_attribute("version", type_of(&version), &version);
  return CheckpointFile(std::move(impl));
}

CheckpointFile CheckpointFile::open(const Comm& comm, const std::string& path) {
  start_hdf5();
  auto impl = std::make_unique<Impl>();
  impl->comm = comm;
  impl->path = path;
  comm.agree([&] { impl->look(); });
  comm.agree([&] { impl->open(); });
  return CheckpointFile(std::move(impl));
}

namespace {
template <class T>
const std::byte* bytes(std::span<const T> values) {
  return reinterpret_cast<const std::byte*>(values.data());
}
}  // namespace

void CheckpointFile::write(const std::string& name, std::span<const double> mine, int columns) {
  impl_->write(name, type_of(mine.data()), bytes(mine), mine.size(), columns);
}
void CheckpointFile::write(const std::string& name, std::span<const std::int64_t> mine, int columns) {
  impl_->write(name, type_of(mine.data()), bytes(mine), mine.size(), columns);
}
void CheckpointFile::write(const std::string& name, std::span<const std::int32_t> mine, int columns) {
  impl_->write(name, type_of(mine.data()), bytes(mine), mine.size(), columns);
}
void CheckpointFile::write(const std::string& name, std::span<const std::uint8_t> mine, int columns) {
  impl_->write(name, type_of(mine.data()), bytes(mine), mine.size(), columns);
}
void CheckpointFile::write_text(const std::string& name, const std::string& text) { impl_->write_text(name, text); }
void CheckpointFile::write_number(const std::string& name, double value) {
  impl_->write_attribute(name, type_of(&value), &value);
}
void CheckpointFile::commit() { impl_->commit(); }

std::int64_t CheckpointFile::rows(const std::string& name) const {
  return static_cast<std::int64_t>(impl_->shape(name, impl_->dataset(name))[0]);
}
bool CheckpointFile::has(const std::string& name) const { return impl_->has(name); }
std::string CheckpointFile::read_text(const std::string& name) const { return impl_->read_text(name); }
double CheckpointFile::read_number(const std::string& name) const { return impl_->read_number(name); }

template <class T>
std::vector<T> CheckpointFile::read_rows(const std::string& name, std::int64_t first, std::int64_t n,
                                         int columns) const {
  std::vector<T> values;
  const Type type = type_of(values.data());
  impl_->read(name, type, first, n, columns, [&] {
    values.resize(std::size_t(n) * columns);
    return values.data();
  });
  return values;
}

template std::vector<double> CheckpointFile::read_rows(const std::string&, std::int64_t, std::int64_t, int) const;
template std::vector<std::int64_t> CheckpointFile::read_rows(const std::string&, std::int64_t, std::int64_t, int) const;
template std::vector<std::int32_t> CheckpointFile::read_rows(const std::string&, std::int64_t, std::int64_t, int) const;
template std::vector<std::uint8_t> CheckpointFile::read_rows(const std::string&, std::int64_t, std::int64_t, int) const;

}  // namespace berm
