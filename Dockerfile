FROM python:3.13-slim AS build

WORKDIR /src
ENV PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_NO_CACHE_DIR=1 PIP_ROOT_USER_ACTION=ignore

# With a folder wheels/ (docker/wheels makes one) nothing is fetched while building; without it
# the package index is asked as usual. This layer stays as long as pyproject.toml does.
COPY pyproject.toml wheel[s] wheels/
COPY docker/install docker/install
RUN mv wheels/pyproject.toml . && sh docker/install dependencies

COPY README.md LICENSE ./
COPY tca_bus tca_bus
COPY rogue rogue
COPY navigate navigate
COPY xavier_sim xavier_sim
RUN sh docker/install packages


FROM python:3.13-slim

RUN useradd --create-home office && install -d -o office /data
COPY --from=build /opt/office /opt/office
COPY docker/present /usr/local/bin/present

ENV PATH=/opt/office/bin:$PATH PYTHONUNBUFFERED=1
USER office
WORKDIR /home/office
VOLUME /data
CMD ["tca", "status"]
