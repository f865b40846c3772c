private:
    /* How many numbers a container holds, where its type tells: 0 where it does not. */
    template <class C, class = void> struct held {
        static constexpr std::size_t size = 0;
        static constexpr bool plain = true; /* one after the other, matrices row by row */
    };
    template <class C> struct held<C, decltype(static_cast<void>(std::tuple_size<C>::value))> {
        static constexpr std::size_t size = std::tuple_size<C>::value;
        static constexpr bool plain = true;
    };
    template <class C> struct held<C, decltype(static_cast<void>(C::extent))> {
        static constexpr bool dynamic = C::extent == static_cast<std::size_t>(-1);
        static constexpr std::size_t size = dynamic ? 0 : C::extent;
        static constexpr bool plain = true;
    };
    template <class C> struct held<C, decltype(static_cast<void>(C::SizeAtCompileTime))> { /* Eigen */
        static constexpr int fixed = static_cast<int>(C::SizeAtCompileTime);
        static constexpr int columns = static_cast<int>(C::ColsAtCompileTime);
        static constexpr int outer = static_cast<int>(C::OuterStrideAtCompileTime);
        static constexpr bool rows = static_cast<bool>(C::IsRowMajor) && outer == columns;
        static constexpr std::size_t size = fixed < 0 ? 0 : static_cast<std::size_t>(fixed);
        static constexpr bool plain = static_cast<int>(C::InnerStrideAtCompileTime) == 1
            && (static_cast<bool>(C::IsVectorAtCompileTime) || rows);
    };

public:
    /* N numbers that somebody else holds. */
    template <class T, std::size_t N> class view {
    public:
        static constexpr std::size_t extent = N;
        constexpr view(T (&numbers)[N]) noexcept : first_(numbers) {}
        /* For N numbers from here on, unchecked. */
        constexpr explicit view(T *first) noexcept : first_(first) {}
        template <class C,
            class = std::enable_if_t<std::is_convertible_v<decltype(std::declval<C &>().data()), T *>>>
        constexpr view(C &&numbers) noexcept : first_(numbers.data())
        {
            using of = held<std::remove_cv_t<std::remove_reference_t<C>>>;
            static_assert(of::size == 0 || of::size == N, "another number of entries is needed");
            static_assert(of::plain, "a row-major matrix without gaps is needed");
            assert(static_cast<std::size_t>(numbers.size()) == N);
        }
        constexpr T *data() const noexcept { return first_; }
        constexpr std::size_t size() const noexcept { return N; }
        constexpr T &operator[](std::size_t i) const noexcept { return first_[i]; }
        constexpr T *begin() const noexcept { return first_; }
        constexpr T *end() const noexcept { return first_ + N; }

    private:
        T *first_;
    };
    template <std::size_t N> using input = view<const real, N>;
    template <std::size_t N> using output = view<real, N>;
