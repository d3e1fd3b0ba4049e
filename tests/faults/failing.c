// Makes one call of the C library fail: of those that touch files under a folder, or of those that
// allocate. Preloaded; told by fail_files() from inside, or by the environment. Left out: what only
// looks (stat, access, folders), links, locks, maps, and calls on folders that are open.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

static char under[PATH_MAX];  // empty: nothing is counted
static atomic_long calls = 0;
static long at = -1;  // which call fails
static int with = 0;  // its errno; 0: a write that takes half; -1: stands still; -2: for a while
static atomic_bool stands = false;
static bool has_failed = false;
static _Thread_local bool takes_half = false;

// From now on the n-th call that touches a file under the folder fails; none for n < 0.
void fail_files(const char* folder, long n, int error) {
  snprintf(under, sizeof under, "%s", folder);
  calls = 0;
  has_failed = stands = false;
  with = error;
  at = n;
}

// Whether a call stands still; until the next fail_files() or a signal of its thread.
bool file_stands(void) { return stands; }

static bool stand_still(void) {
  const struct timespec ms = {0, 1000000};
  sigset_t all, before;
  sigfillset(&all);
  has_failed = stands = true;
  // Between two waits a signal stays pending: on a loaded machine most come there.
  pthread_sigmask(SIG_SETMASK, &all, &before);
  bool signalled = false;
  for (int waited = 0; stands && !signalled && (with == -1 || waited < 300); ++waited) {
    signalled = ppoll(NULL, 0, &ms, &before) != 0;
  }
  pthread_sigmask(SIG_SETMASK, &before, NULL);
  if (signalled) stands = false;
  return signalled;
}

long file_calls(void) { return calls; }
bool file_failed(void) { return has_failed; }

static bool fails(const char* path) {
  takes_half = false;
  if (under[0] == '\0' || path == NULL || strncmp(path, under, strlen(under)) != 0) return false;
  if (atomic_fetch_add(&calls, 1) != at) return false;
  has_failed = with > 0;
  if (with < 0) return stand_still();
  takes_half = !has_failed;
  errno = with;
  return has_failed;
}

static bool fails_fd(int fd) {
  takes_half = false;
  if (under[0] == '\0') return false;
  char link[64], path[PATH_MAX];
  snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const int before = errno;
  const ssize_t size = readlink(link, path, sizeof path - 1);
  errno = before;
  if (size < 0) return false;
  path[size] = '\0';
  return fails(path);
}

#define NEXT(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

#define OPEN(name)                                           \
  int name(const char* path, int flags, ...) {               \
    va_list more;                                            \
    va_start(more, flags);                                   \
    const mode_t mode = va_arg(more, mode_t);                \
    va_end(more);                                            \
    return fails(path) ? -1 : NEXT(name)(path, flags, mode); \
  }
OPEN(open)
OPEN(open64)

#define OPENAT(name)                                                 \
  int name(int folder, const char* path, int flags, ...) {           \
    va_list more;                                                    \
    va_start(more, flags);                                           \
    const mode_t mode = va_arg(more, mode_t);                        \
    va_end(more);                                                    \
    return fails(path) ? -1 : NEXT(name)(folder, path, flags, mode); \
  }
OPENAT(openat)
OPENAT(openat64)

#define FOPEN(name)                                     \
  FILE* name(const char* path, const char* mode) {      \
    return fails(path) ? NULL : NEXT(name)(path, mode); \
  }
FOPEN(fopen)
FOPEN(fopen64)

ssize_t write(int fd, const void* data, size_t size) {
  if (fails_fd(fd)) return -1;
  has_failed |= takes_half;
  return NEXT(write)(fd, data, takes_half ? (size + 1) / 2 : size);
}
ssize_t writev(int fd, const struct iovec* data, int count) {
  return fails_fd(fd) ? -1 : NEXT(writev)(fd, data, count);
}
ssize_t read(int fd, void* data, size_t size) {
  return fails_fd(fd) ? -1 : NEXT(read)(fd, data, size);
}
int close(int fd) {
  struct stat what;  // a folder's is nobody's
  if (fstat(fd, &what) != 0 || !S_ISREG(what.st_mode) || !fails_fd(fd)) return NEXT(close)(fd);
  const int failed = errno;
  NEXT(close)(fd);
  errno = failed;
  return -1;
}
size_t fwrite(const void* data, size_t size, size_t count, FILE* file) {
  return fails_fd(fileno(file)) ? 0 : NEXT(fwrite)(data, size, count, file);
}

#define ON(type, name, failed, parameters, arguments) \
  type name parameters { return failed ? -1 : NEXT(name) arguments; }
ON(int, fsync, fails_fd(fd), (int fd), (fd))
ON(int, ftruncate, fails_fd(fd), (int fd, off_t size), (fd, size))
ON(int, ftruncate64, fails_fd(fd), (int fd, off64_t size), (fd, size))
// It waits for nothing, and Python forgets an interrupt there.
ON(off_t, lseek, with >= 0 && fails_fd(fd), (int fd, off_t to, int from), (fd, to, from))
ON(off64_t, lseek64, with >= 0 && fails_fd(fd), (int fd, off64_t to, int from), (fd, to, from))
ON(int, fchmod, fails_fd(fd), (int fd, mode_t mode), (fd, mode))
ON(int, chmod, fails(path), (const char* path, mode_t mode), (path, mode))
ON(int, chown, fails(path), (const char* path, uid_t user, gid_t group), (path, user, group))
ON(int, unlink, fails(path), (const char* path), (path))
ON(int, mkdir, fails(path), (const char* path, mode_t mode), (path, mode))
ON(int, rename, fails(to), (const char* from, const char* to), (from, to))
ON(int, renameat, fails(to), (int a, const char* from, int b, const char* to), (a, from, b, to))

// Allocations: FAIL_ALLOCATION=n, and where FAIL_COUNT says how many there were.

extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
static atomic_long allocations = 0;
static long allocation = -2;  // -2: not asked yet

static bool runs_out(void) {
  if (allocation == -2) {
    const char* told = getenv("FAIL_ALLOCATION");
    allocation = told == NULL ? -1 : atol(told);
  }
  if (atomic_fetch_add(&allocations, 1) != allocation) return false;
  errno = ENOMEM;
  return true;
}

void* malloc(size_t size) { return runs_out() ? NULL : __libc_malloc(size); }
void* calloc(size_t count, size_t size) { return runs_out() ? NULL : __libc_calloc(count, size); }
void* realloc(void* old, size_t size) { return runs_out() ? NULL : __libc_realloc(old, size); }

__attribute__((destructor)) static void tell(void) {
  const char* place = getenv("FAIL_COUNT");
  FILE* file = place == NULL ? NULL : NEXT(fopen)(place, "w");
  if (file == NULL) return;
  fprintf(file, "%ld\n", (long)allocations);
  fclose(file);
}
