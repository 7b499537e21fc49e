// guest-init.c: the two ends of a guest of tools/vcan-guest.   gcc -O2 -static -o init guest-init.c
//
//   as process 1 of the guest      mounts, vcan0, runs the command; what it prints goes to the spool, its
//                                  exit status to the file "status"
//   init relay SPOOL PID SECONDS   on the host: copies the spool to standard output and error, live, until
//                                  process PID (the guest) has ended; exit status 124 after SECONDS (0: never)
//
// In user-mode Linux the host's files are the root from the beginning (hostfs); in QEMU's PC process 1 starts from
// an initramfs with modules to insert, and the host's files come through 9p.
//
// The spool is a file in a folder that both sides see. Its records are {stream, length} and the data: one
// file keeps the order across the two streams, and no terminal touches a byte. A file never blocks the guest
// either, so a slow reader on the host cannot disturb virtual time.
//
// From the guest's kernel command line, as an environment variable of process 1:
//   guest_start=SECS   virtual time only: the command starts at exactly this CLOCK_REALTIME
// The runner's folder on the host is the current folder of the guest's kernel process: its name differs from
// run to run, and so it must not be part of the command line (see SeedRandom). It is /run/guest in the guest. In
// it: command, a list of strings each ended by NUL (current folder, output folder on the host and in the guest,
// number of variables, variables, command, arguments); stdin, spool, status, out.
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <linux/if_link.h>
#include <linux/random.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/reboot.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

struct Record {
  uint32_t stream;  // file descriptor of the command: 1 or 2
  uint32_t length;  // bytes that follow
};
enum { kChunk = 1 << 16 };  // what a pipe holds

// ---------------------------------------------------------------------------------------------- on the host

static void TimedOut(int signal) {
  (void)signal;
  _exit(124);
}

static void WriteAll(int fd, const char* data, size_t size) {
  while (size > 0) {
    ssize_t n = write(fd, data, size);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      fprintf(stderr, "vcan-guest: cannot write standard %s: %s\n", fd == 1 ? "output" : "error",
              strerror(errno));
      _exit(125);
    }
    data += n;
    size -= (size_t)n;
  }
}

// Copies every byte that the spool holds so far.
static void CopySpool(int spool) {
  static off_t at, punched;
  static struct Record record;  // of which `length` bytes are still to come
  static char data[kChunk];
  for (;;) {
    if (record.length == 0) {
      if (pread(spool, &record, sizeof record, at) != sizeof record) {
        record.length = 0;
        return;
      }
      at += (off_t)sizeof record;
    }
    ssize_t n = pread(spool, data, record.length < kChunk ? record.length : kChunk, at);
    if (n <= 0) return;
    WriteAll((int)record.stream, data, (size_t)n);
    at += n;
    record.length -= (uint32_t)n;
    if (at - punched > 16 << 20) {  // give the room back, so that a long run does not fill the disk
      fallocate(spool, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, punched, at - punched);
      punched = at;
    }
  }
}

static int Relay(const char* path, pid_t guest, unsigned seconds) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  signal(SIGALRM, TimedOut);
  alarm(seconds);
  int spool = open(path, O_RDWR | O_CLOEXEC);
  if (spool < 0) {
    perror(path);
    return 125;
  }
  struct pollfd ended = {.fd = (int)syscall(SYS_pidfd_open, guest, 0), .events = POLLIN};
  int last = 0;
  while (!last) {
    last = ended.fd < 0 || poll(&ended, 1, 10) > 0;  // 10 ms: what a reader sees as live
    CopySpool(spool);
  }
  return 0;
}

// --------------------------------------------------------------------------------------------- in the guest

static void PowerOff(void) {
  sync();
  reboot(RB_POWER_OFF);
  for (;;) pause();
}

// The line goes to the kernel's log, which the runner keeps and quotes.
static void Die(const char* what) {
  int error = errno;
  int log = open("/dev/kmsg", O_WRONLY | O_CLOEXEC);
  dprintf(log, "<3>guest-init: %s: %s\n", what, strerror(error));
  PowerOff();
}

static void Mount(const char* source, const char* dir, const char* type, const char* options) {
  for (char *path = strdup(dir), *slash = path + 1; (slash = strchr(slash, '/')); *slash++ = '/') {
    *slash = 0;
    mkdir(path, 0755);
  }
  mkdir(dir, 0755);
  if (mount(source, dir, type, 0, options) != 0) Die(dir);
}

static void AddAttribute(struct nlmsghdr* message, unsigned short type, const void* data, size_t size) {
  struct rtattr* attribute = (void*)((char*)message + NLMSG_ALIGN(message->nlmsg_len));
  attribute->rta_type = type;
  attribute->rta_len = (unsigned short)RTA_LENGTH(size);
  memcpy(RTA_DATA(attribute), data, size);
  message->nlmsg_len = (uint32_t)(NLMSG_ALIGN(message->nlmsg_len) + RTA_ALIGN(attribute->rta_len));
}

// ip link add NAME type vcan
static void AddVcan(const char* name) {
  struct {
    struct nlmsghdr header;
    struct ifinfomsg link;
    char attributes[128];
  } request = {.header = {.nlmsg_len = NLMSG_LENGTH(sizeof request.link),
                          .nlmsg_type = RTM_NEWLINK,
                          .nlmsg_flags = NLM_F_REQUEST | NLM_F_ACK | NLM_F_CREATE | NLM_F_EXCL}};
  struct {
    struct nlmsghdr header;
    struct nlmsgerr error;
    char rest[512];
  } reply;
  struct {
    struct rtattr kind;
    char name[4];
  } info = {{.rta_len = RTA_LENGTH(4), .rta_type = IFLA_INFO_KIND}, {'v', 'c', 'a', 'n'}};
  AddAttribute(&request.header, IFLA_IFNAME, name, strlen(name) + 1);
  AddAttribute(&request.header, IFLA_LINKINFO, &info, sizeof info);
  int s = socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
  if (s < 0 || send(s, &request, request.header.nlmsg_len, 0) < 0 || recv(s, &reply, sizeof reply, 0) < 0) {
    Die("rtnetlink");
  }
  if (reply.error.error != 0) {
    errno = -reply.error.error;
    Die(name);
  }
  close(s);
}

static void BringUp(const char* name) {
  struct ifreq request = {0};
  strcpy(request.ifr_name, name);
  int s = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (ioctl(s, SIOCGIFFLAGS, &request) != 0) Die(name);
  request.ifr_flags |= IFF_UP;
  if (ioctl(s, SIOCSIFFLAGS, &request) != 0) Die(name);
  close(s);
}

// A file's strings, each ended by NUL, as a list ended by a null pointer.
static char** ReadStrings(const char* path) {
  int fd = open(path, O_RDONLY | O_CLOEXEC);
  struct stat info;
  if (fd < 0 || fstat(fd, &info) != 0) Die(path);
  size_t size = (size_t)info.st_size, have = 0, count = 0;
  char* text = calloc(size + 1, 1);
  char** strings = calloc(size + 1, sizeof *strings);
  while (have < size) {
    ssize_t n = read(fd, text + have, size - have);
    if (n <= 0) Die(path);
    have += (size_t)n;
  }
  for (char* next = text; next < text + size; next += strlen(next) + 1) strings[count++] = next;
  close(fd);
  return strings;
}

// A folder of the host: by its path where that is known (hostfs), else by its tag.
static void MountHost(const char* tag, const char* host, const char* dir) {
  if (host) {
    Mount(tag, dir, "hostfs", host);
  } else {
    Mount(tag, dir, "9p", "trans=virtio,version=9p2000.L,msize=512000,cache=mmap");
  }
}

static void Insert(const char* path) {
  int fd = open(path, O_RDONLY | O_CLOEXEC);
  if (fd < 0 || syscall(SYS_finit_module, fd, "", 0) != 0) Die(path);
  close(fd);
}

// From the initramfs to the host's files.
static void EnterHost(const char* modules) {
  char path[256];
  Mount("dev", "/dev", "devtmpfs", NULL);  // for Die
  FILE* list = fopen(modules, "re");
  if (!list) Die(modules);
  while (fgets(path, sizeof path, list)) {
    path[strcspn(path, "\n")] = 0;
    Insert(path);
  }
  fclose(list);
  mkdir("/host", 0755);
  if (mount("root", "/host", "9p", MS_RDONLY, "trans=virtio,version=9p2000.L,msize=512000,cache=loose") != 0 ||
      chdir("/host") != 0 || mount(".", "/", NULL, MS_MOVE, NULL) != 0 || chroot(".") != 0 || chdir("/") != 0) {
    Die("the host's files");
  }
}

static void Mounts(const char* work) {
  Mount("dev", "/dev", "devtmpfs", NULL);
  Mount("proc", "/proc", "proc", NULL);
  Mount("sysfs", "/sys", "sysfs", NULL);
  Mount("tmpfs", "/run", "tmpfs", "mode=755");
  Mount("tmpfs", "/dev/shm", "tmpfs", "mode=1777");
  Mount("devpts", "/dev/pts", "devpts", "ptmxmode=666");
  Mount("mqueue", "/dev/mqueue", "mqueue", NULL);
  const char* const links[][2] = {{"/proc/self/fd", "/dev/fd"},
                                  {"/proc/self/fd/0", "/dev/stdin"},
                                  {"/proc/self/fd/1", "/dev/stdout"},
                                  {"/proc/self/fd/2", "/dev/stderr"}};
  for (size_t i = 0; i < 4; ++i) {
    if (symlink(links[i][0], links[i][1]) != 0) Die(links[i][1]);
  }
  // /tmp shows the host's files and takes new ones, which end with the guest.
  umask(0);
  mkdir("/run/tmp", 0755);
  mkdir("/run/tmp/upper", 01777);
  mkdir("/run/tmp/work", 0755);
  umask(022);
  Mount("tmp", "/tmp", "overlay", "lowerdir=/tmp,upperdir=/run/tmp/upper,workdir=/run/tmp/work");
  mkdir("/run/home", 0700);
  MountHost("work", work, "/run/guest");
}

// The kernel has no sources of randomness but its clock and its command line (build-kernel.sh), so that runs
// in virtual time repeat. Without this, the first program that wants a random number waits 0.9 s of virtual
// time (measured) until the kernel calls its pool ready.
static void SeedRandom(void) {
  struct {
    struct rand_pool_info info;
    char seed[32];
  } pool = {{.entropy_count = 256, .buf_size = 32}, "servohil"};
  int fd = open("/dev/urandom", O_RDWR | O_CLOEXEC);
  if (fd < 0 || ioctl(fd, RNDADDENTROPY, &pool) != 0) Die("/dev/urandom");
  close(fd);
}

static void Exec(const char* dir, char** variables, char** command, int out, int err) {
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, NULL);
  setsid();
  dup2(open("/run/guest/stdin", O_RDONLY | O_CLOEXEC), 0);
  dup2(out, 1);
  dup2(err, 2);
  if (chdir(dir) != 0) {
    fprintf(stderr, "vcan-guest: cannot enter %s in the guest: %s\n", dir, strerror(errno));
    _exit(125);
  }
  environ = variables;
  execvp(command[0], command);
  int error = errno;
  fprintf(stderr, "vcan-guest: %s: %s\n", command[0],
          error == ENOENT ? "command not found" : strerror(error));
  _exit(error == ENOENT ? 127 : 126);
}

// Moves what the pipe holds, one chunk at most, to the spool. False when there is nothing (now or ever).
static int Pump(int pipe, uint32_t stream, int spool) {
  static struct {
    struct Record record;
    char data[kChunk];
  } chunk;
  ssize_t n = read(pipe, chunk.data, kChunk);
  if (n <= 0) return 0;
  chunk.record = (struct Record){stream, (uint32_t)n};
  const char* next = (const char*)&chunk;
  for (size_t left = sizeof chunk.record + (size_t)n; left > 0;) {
    ssize_t written = write(spool, next, left);
    if (written < 0) Die("the host has no room for the output");
    next += written;
    left -= (size_t)written;
  }
  return 1;
}

// Runs the command, and collects every other process that ends here. Returns the command's exit status.
static int Run(const char* dir, char** variables, char** command) {
  int spool = open("/run/guest/spool", O_WRONLY | O_APPEND | O_CLOEXEC);
  int out[2], err[2];
  sigset_t child;
  sigemptyset(&child);
  sigaddset(&child, SIGCHLD);
  sigprocmask(SIG_BLOCK, &child, NULL);
  int ended = signalfd(-1, &child, SFD_CLOEXEC | SFD_NONBLOCK);
  if (spool < 0 || ended < 0 || pipe2(out, O_CLOEXEC) != 0 || pipe2(err, O_CLOEXEC) != 0) Die("spool");
  fcntl(out[0], F_SETFL, O_NONBLOCK);
  fcntl(err[0], F_SETFL, O_NONBLOCK);

  // Above every ordinary process: each write is taken before the writer goes on, which keeps the two streams
  // in order.
  if (sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &(struct sched_param){1}) != 0)
    Die("scheduler");
  pid_t command_pid = fork();
  if (command_pid < 0) Die("fork");
  if (command_pid == 0) Exec(dir, variables, command, out[1], err[1]);
  close(out[1]);
  close(err[1]);

  struct pollfd sources[] = {{out[0], POLLIN, 0}, {err[0], POLLIN, 0}, {ended, POLLIN, 0}};
  for (;;) {
    poll(sources, 3, -1);
    for (uint32_t i = 0; i < 2; ++i) {
      if (sources[i].revents != 0 && !Pump(sources[i].fd, i + 1, spool)) sources[i].fd = -1;  // closed by all
    }
    struct signalfd_siginfo ignored;
    while (read(ended, &ignored, sizeof ignored) > 0) continue;
    int status;
    for (pid_t pid; (pid = waitpid(-1, &status, WNOHANG)) > 0;) {
      if (pid != command_pid) continue;
      while (Pump(out[0], 1, spool) | Pump(err[0], 2, spool)) continue;
      return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
  }
}

static int Init(void) {
  const char* start = getenv("guest_start");
  const char* modules = "/modules/list";
  int is_pc = access(modules, R_OK) == 0;
  if (is_pc) EnterHost(modules);
  const char* work = is_pc ? NULL : realpath("/proc/self/cwd", NULL);  // /proc is still the host's
  if (!is_pc && !work) Die("/proc/self/cwd");
  Mounts(work);
  for (int fd = 0; fd < 3; ++fd) dup2(open("/dev/null", O_RDWR), fd);

  char** strings = ReadStrings("/run/guest/command");
  const char* dir = *strings++;
  const char* out_host = *strings++;
  const char* out = *strings++;
  long count = strtol(*strings++, NULL, 10);
  char** variables = calloc((size_t)count + 1, sizeof *variables);
  for (long i = 0; i < count; ++i) variables[i] = *strings++;

  MountHost("out", is_pc ? NULL : out_host, out);
  SeedRandom();
  sethostname("guest", 5);
  BringUp("lo");
  AddVcan("vcan0");
  BringUp("vcan0");
  nanosleep(&(struct timespec){0, 50000000}, NULL);  // to the first tick, when timers become high-resolution
  if (start)
    clock_nanosleep(CLOCK_REALTIME, TIMER_ABSTIME, &(struct timespec){strtol(start, NULL, 10), 0}, NULL);

  int status = Run(dir, variables, strings);
  kill(-1, SIGKILL);
  int fd = open("/run/guest/status", O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0 || dprintf(fd, "%d\n", status) < 0) Die("status");
  PowerOff();
  return 1;
}

int main(int argc, char** argv) {
  if (argc == 5 && strcmp(argv[1], "relay") == 0) {
    return Relay(argv[2], (pid_t)strtol(argv[3], NULL, 10), (unsigned)strtoul(argv[4], NULL, 10));
  }
  if (getpid() == 1) return Init();
  fputs("guest-init is run by tools/vcan-guest\n", stderr);
  return 2;
}
