# Compiles the project in /work: docs/install.md shows how to build and run the image.
FROM python:3.12-slim AS build
WORKDIR /src
COPY MANIFEST.in pyproject.toml setup.py README.md LICENSE NOTICE package.xml ./
COPY ament/resource ament/resource
COPY bazel bazel
COPY cmake cmake
COPY compiler compiler
COPY parts parts
COPY schemas schemas
COPY templates templates
COPY viewer/built viewer/built
RUN pip wheel --no-cache-dir --no-deps --wheel-dir /wheels .

FROM python:3.12-slim
ARG EXTRAS=import,physics,simulate,view
COPY --from=build /wheels /wheels
RUN pip install --no-cache-dir "$(echo /wheels/*.whl)${EXTRAS:+[$EXTRAS]}" && useradd --create-home robot
USER robot
WORKDIR /work
ENTRYPOINT ["rosorin-compile"]
CMD ["--help"]
