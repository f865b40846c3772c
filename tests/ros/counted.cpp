// Counts allocations and locks in cycles of a controller, and in one of each for control.
#include <dlfcn.h>
#include <pthread.h>

#include <cstdio>
#include <cstdlib>
#include <mutex>

#include "host.cpp"

static bool counting = false;
static int allocations = 0;
static int locks = 0;

extern "C" {
void * __libc_malloc(std::size_t);

void * malloc(std::size_t size)
{
  allocations += counting;
  return __libc_malloc(size);
}

int pthread_mutex_lock(pthread_mutex_t * mutex)
{
  static int (* const lock)(pthread_mutex_t *) =
    reinterpret_cast<int (*)(pthread_mutex_t *)>(dlsym(RTLD_NEXT, "pthread_mutex_lock"));
  locks += counting;
  return lock(mutex);
}
}

int main(int, char ** arguments)
{
  Host * const host = open_host(arguments[1]);
  set_text(host, "feedforward", "full");
  const std::vector<double> gains(6, 10.0);
  set_numbers(host, "gains.p", gains.data(), 6);
  if (start_controller(host, arguments[2], "") != 0) {
    return 1;
  }
  std::vector<double> state(host->names[1].size(), 0.1);
  const std::vector<double> references(host->names[2].size(), 0.2);
  const double body[10] = {1.0};
  std::mutex mutex;
  chain(host, 1);
  set_references(host, references.data());
  for (int i = 0; i < 100; ++i) {
    publish_load(host, "tool0", body);
    counting = true;
    cycle(host, state.data());
    counting = false;
  }
  std::printf("allocations %d locks %d ", allocations, locks);
  allocations = locks = 0;
  counting = true;
  std::free(std::malloc(1000));
  mutex.lock();
  counting = false;
  std::printf("control %d %d\n", allocations, locks);
  return 0;
}
